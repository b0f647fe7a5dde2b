#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"
#include "Core/Prediction/LinearFilter.h"

#include <array>
#include <functional>
#include <optional>
#include <span>

namespace innergs {

/// The learned filter and network, ready to be applied.
struct SliceModel {
  SliceSampling sampling;
  PatchFilter filter;
  std::optional<ConvolutionNetwork> network;
  ConvolutionNetwork::Transforms transforms; // of the network
  float floor = 0;                           // minimum of the patches' deviation, image units
};

/// How often a plane is predicted: unreflected only, or with reflections.
enum class Reflections { None, Two, Four };

/// The stack's thin samples, predicted in the planes along I and in those along J that contain the slice
/// normal, on the grid that the sampling was made for.
/// wanted: 1 for the image's voxels whose thin samples are wanted; others may be left 0. Progress: 0…1.
std::array<std::vector<float>, 2> applyAcrossSlices(const SliceModel& model, const Volume& image,
                                                    std::span<const std::uint8_t> wanted,
                                                    Reflections reflections, const NetworkKernels& kernels,
                                                    const GridGeometry& thin, ThreadPool& pool,
                                                    const std::function<void(double)>& progress);

/// output[sample][outputStride]: the prediction's difference from the patch mean, divided by the deviation.
void predictSamples(const SliceModel& model, const PatchFeatures& features, const NetworkKernels& kernels,
                    ConvolutionNetwork::Workspace& work, std::vector<float>& output);

} // namespace innergs
