#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <functional>
#include <optional>
#include <string>

namespace innergs {

/// How much is spent on learning what lies between the slices.
enum class PredictionEffort {
  Filter, // a linear filter in closed form
  Fast,   // and a small network, trained briefly
  Balanced,
  Best
};

struct PredictionOptions {
  PredictionEffort effort = PredictionEffort::Balanced;
  /// Where to predict: the stack's own lattice in-plane, any spacing and any first position along K. Unset:
  /// predictionGrid().
  std::optional<GridGeometry> grid;
  /// σ of the Gaussian blur, in in-plane samples, that makes the training images as smooth as the scan is
  /// across its slices. Unset: estimated from the scan.
  std::optional<double> matchingBlur;
  std::uint64_t seed = 1;
  std::string instructionSet; // "" = best available; "scalar" = the plain reference
};

enum class PredictionPhase { Matching, Learning, Applying };
const char* predictionPhaseName(PredictionPhase phase);

struct PredictionProgress {
  PredictionPhase phase = PredictionPhase::Matching;
  double fraction = 0; // of the whole prediction, 0…1, never decreases
};
/// Called on the thread that predicts.
using PredictionCallback = std::function<void(const PredictionProgress&)>;

/// Root mean square errors in image units on simulated pairs: in-plane images of this scan, degraded as its
/// slices are, in slices that took no part in the learning. One plane's prediction, not the mean of two.
struct PairErrors {
  double linear = 0, cubic = 0; // interpolation between the slices
  double filter = 0;            // the linear filter
  double network = 0;           // network and filter together; as filter where there is no network
  std::int64_t samples = 0;     // that were scored
};

/// What was learned from a scan, and the scan with what it predicts between its slices.
struct Prediction {
  bool learned = false; // false: image is empty, the sentence says why, callers interpolate
  std::string sentence; // for the user: what was learned, or why nothing was
  Volume image;         // on the grid asked for; scanner units, finite everywhere
  /// Per voxel of image, 1 = predicted, 0 = interpolated because unobserved or non-finite voxels lie near.
  /// Empty: all predicted.
  std::vector<std::uint8_t> predicted;
  std::vector<float> expectedError; // per K slice of image: RMS in image units, 0 on an acquired thin slice
  PairErrors pairs;
  double blur = 0; // σ of the matching blur, in in-plane samples
  int phases = 0;  // samples predicted per slice distance
  double learningSeconds = 0, applyingSeconds = 0;
};

/// The lattice that covers the stack's box with the stack's in-plane lattice and round(k) ≥ 2 samples per
/// slice, k = slice spacing / finer in-plane spacing.
GridGeometry predictionGrid(const GridGeometry& stack);

/// Learns from the stack's own in-plane detail, degraded along one in-plane axis as the slices are by their
/// profile and spacing, what lies between the slices; applies it in both planes that hold the slice normal.
/// Withheld (Stack::observed) and non-finite voxels are never looked at. Stack::thickness and profile are
/// taken as true; poses and times are ignored. Same bits at any number of threads of the pool.
/// Nothing is learned, with a sentence, for k < 1.2 or k > 12, too few slices or pixels, constant images and
/// images of labels. Throws Error(Cancelled) when the pool's stop token says so, what checkStack throws, and
/// Error(InvalidArgument) for a grid that is not aligned with the stack's.
Prediction predictAcrossSlices(const Stack& stack, const PredictionOptions& options, ThreadPool& pool,
                               const PredictionCallback& progress = {});

} // namespace innergs
