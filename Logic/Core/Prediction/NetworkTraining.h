#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"
#include "Core/Prediction/LinearFilter.h"

#include <functional>

namespace innergs {

/// How a network is trained on the mean squared error of what the filter leaves: weights by orthogonalised
/// momentum, biases by Adam; the rate rises to `rate` and falls to 0.
struct TrainingPlan {
  int channels = 32, layers = 4;
  int steps = 3000;
  int pairs = 2; // per step
  PairShape most{24, 48};
  double rate = 4e-3;
  float floor = 1; // minimum of the deviation, image units
};

/// Bit-identical for any number of threads: the sums of a step's pairs are added in order. Progress: 0…1.
ConvolutionNetwork trainNetwork(const TrainingPlanes& planes, const SliceSampling& sampling,
                                const PatchFilter& filter, const PairShape& shape, const TrainingPlan& plan,
                                double pairNoise, std::uint64_t seed, const MatrixKernels& kernels,
                                ThreadPool& pool, const std::function<void(double)>& progress);

/// Training samples.
struct TrainingBatch {
  PatchFeatures features;
  std::vector<float> thin;          // [sample][phase], image units
  std::vector<std::uint8_t> counts; // per sample
};

/// Adds the gradient of the loss on a batch: the sum of squared errors after filter and network, in units of
/// the patches' deviation. Returns the loss; `counted`: the number of squares in it.
double batchLoss(const ConvolutionNetwork& network, const PatchFilter& filter, const TrainingBatch& batch,
                 const std::vector<float>& transposed, const MatrixKernels& kernels,
                 ConvolutionNetwork::Workspace& work, std::vector<float>& gradient, double& counted);

} // namespace innergs
