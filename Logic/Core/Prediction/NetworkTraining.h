#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"
#include "Core/Prediction/LinearFilter.h"

#include <functional>
#include <span>

namespace innergs {

/// What pairs are drawn from: the images of one scan, degraded like its slices.
struct TrainingSource {
  const TrainingPlanes& planes;
  const SliceSampling& sampling; // the same number of phases in all sources of a training
  const PatchFilter& filter;
  PairShape shape;
  float floor = 1;      // minimum of the deviation, image units
  double pairNoise = 0; // image units
};

/// How a network is trained on the mean squared error of what the filter leaves: weights by orthogonalised
/// momentum, biases by Adam; the rate rises to `rate`, stays, and falls to 0.
struct TrainingPlan {
  int channels = 32, layers = 4;
  int steps = 1200;
  int pairs = 2; // per step
  PairShape most{24, 48};
  double rate = 2e-3;
  bool fromScratch = false; // without setStartWeights()
};

/// Each pair comes from one of the sources, drawn at random. Bit-identical for any number of threads: the
/// sums of a step's pairs are added in order. Progress: 0…1.
ConvolutionNetwork trainNetwork(std::span<const TrainingSource> sources, const TrainingPlan& plan,
                                std::uint64_t seed, const NetworkKernels& kernels, ThreadPool& pool,
                                const std::function<void(double)>& progress);

/// Training samples.
struct TrainingBatch {
  PatchFeatures features;
  std::vector<float> thin;          // [sample][phase], image units
  std::vector<std::uint8_t> counts; // per sample
};

/// Adds the gradient of the loss on a batch: the sum of squared errors after filter and network, in units of
/// the patches' deviation. Returns the loss; `counted`: the number of squares in it.
double batchLoss(const ConvolutionNetwork& network, const PatchFilter& filter, const TrainingBatch& batch,
                 const ConvolutionNetwork::Transforms& transforms, const NetworkKernels& kernels,
                 ConvolutionNetwork::Workspace& work, std::vector<float>& gradient, double& counted);

} // namespace innergs
