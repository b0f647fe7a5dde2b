#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"
#include "Core/Prediction/LinearFilter.h"

#include <functional>
#include <optional>

namespace innergs {

/// The learned filter and network, ready to be applied.
struct SliceModel {
  SliceSampling sampling;
  PatchFilter filter;
  std::optional<ConvolutionNetwork> network;
  float floor = 0; // minimum of the patches' deviation, image units
};

/// How often a plane is predicted: unreflected only, or with reflections.
enum class Reflections { None, Two, Four };

/// The stack's thin samples: the mean of the predictions in the two planes that contain the slice normal.
/// thin: the lattice that the sampling was made for; its voxels are overwritten. Progress: 0…1.
void applyAcrossSlices(const SliceModel& model, const Volume& image, Reflections reflections,
                       const MatrixKernels& kernels, Volume& thin, ThreadPool& pool,
                       const std::function<void(double)>& progress);

/// output[sample][outputStride]: the prediction's difference from the patch mean, divided by the deviation.
void predictSamples(const SliceModel& model, const PatchFeatures& features, const MatrixKernels& kernels,
                    ConvolutionNetwork::Workspace& work, std::vector<float>& output);

} // namespace innergs
