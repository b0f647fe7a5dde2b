#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

namespace innergs {

/// The effort spent on learning what lies between the slices.
enum class PredictionEffort {
  Filter, // a linear filter in closed form
  Brief,  // plus a small network with short training
  Fast,   // plus the same network with longer training, applied with reflections like all below
  Balanced,
  Best
};

struct PredictionOptions {
  PredictionEffort effort = PredictionEffort::Balanced;
  /// Where to predict: the stack's own grid in-plane, with any spacing and first position along K. Unset:
  /// predictionGrid().
  std::optional<GridGeometry> grid;
  /// σ of the Gaussian blur, in in-plane samples, that makes the training images as smooth as the scan is
  /// across its slices (CandidateChoice::blur).
  double matchingBlur = 0;
  /// The stack is every second slice of a scan: learns wherever predicting from the whole scan would.
  bool everySecond = false;
  /// 0…1: how much a network improved on the filter in a trial; lengthens the training of Balanced.
  double muchToLearn = 0;
  /// The predictions in the two planes weigh by the gradients along them (PlaneFusion.h); otherwise equally.
  bool fused = true;
  bool fromScratch = false; // the network starts from random weights, not from setStartWeights()
  std::uint64_t seed = 1;
  std::string instructionSet; // "" = best available; "scalar" = the plain reference
};

enum class PredictionPhase { Matching, Learning, Applying };
const char* predictionPhaseName(PredictionPhase phase);

struct PredictionProgress {
  PredictionPhase phase = PredictionPhase::Matching;
  double fraction = 0; // of the whole prediction, 0…1, never decreases
};
/// Called on the predicting thread.
using PredictionCallback = std::function<void(const PredictionProgress&)>;

/// Root mean square errors in image units on simulated pairs: in-plane images of this scan, degraded like its
/// slices, in held-out slices. For the prediction in one plane, not the mean of two.
struct PairErrors {
  double linear = 0, cubic = 0; // interpolation between the slices
  double filter = 0;            // the linear filter
  double network = 0;           // network and filter together; without a network, the filter's
  std::int64_t samples = 0;     // number scored
};

/// What was learned from a scan, and the scan with the predicted samples between its slices.
struct Prediction {
  bool learned = false; // false: image is empty, the sentence says why, callers interpolate
  std::string sentence; // for the user: what was learned, or why nothing was
  Volume image;         // on the requested grid; scanner units, finite everywhere
  Volume mean;          // with PredictionOptions::everySecond and fused: the same with equal weights
  /// For each voxel of image: 1 = predicted, 0 = interpolated because unobserved or non-finite voxels are
  /// near, or because the image is flat there, as in air. Empty: all predicted.
  std::vector<std::uint8_t> predicted;
  PairErrors pairs;
  int phases = 0; // samples predicted per slice distance
  double learningSeconds = 0, applyingSeconds = 0;
};

/// The grid over the stack's box with the stack's in-plane voxels and round(k) ≥ 2 samples per slice, k =
/// slice spacing / finer in-plane spacing.
GridGeometry predictionGrid(const GridGeometry& stack);

/// About how many multiply-adds a prediction takes.
struct PredictionOperations {
  double learning = 0, applying = 0;
  /// The share of each thread; at most two share the learning.
  PredictionOperations perThread(int threads) const {
    return {learning / std::min(threads, 2), applying / threads};
  }
};
PredictionOperations predictionOperations(const GridGeometry& stack, const PredictionOptions& options);

/// Learns what lies between the slices from the stack's own in-plane detail, degraded along one in-plane axis
/// by the slices' profile and spacing, and applies it in both planes that contain the slice normal.
/// Ignores held-out (Stack::observed) and non-finite voxels. Trusts Stack::thickness and profile; ignores
/// poses and times. Bit-identical for any number of threads of the pool.
/// Learns nothing, and says why, for k < 1.2 or k > 12 (24 with everySecond), too few slices or pixels,
/// constant images and labelmaps. Throws Error(Cancelled) if the pool is stopped, what checkStack throws,
/// and Error(InvalidArgument) for a grid that is not aligned with the stack's.
Prediction predictAcrossSlices(const Stack& stack, const PredictionOptions& options, ThreadPool& pool,
                               const PredictionCallback& progress = {});

} // namespace innergs
