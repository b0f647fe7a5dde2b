#include "Core/Prediction/StartWeights.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

namespace innergs {
namespace {

// bfloat16: the upper half of a float.
constexpr std::uint16_t kThin16[] = {
#include "Core/Prediction/StartWeightsThin16.inc"
};
constexpr std::uint16_t kThin32[] = {
#include "Core/Prediction/StartWeightsThin32.inc"
};
constexpr std::uint16_t kThick16[] = {
#include "Core/Prediction/StartWeightsThick16.inc"
};
constexpr std::uint16_t kThick32[] = {
#include "Core/Prediction/StartWeightsThick32.inc"
};
constexpr int kLayers = 4;
constexpr int kPhases = 8;                            // of the last layer
constexpr double kFirstThin = -3, kFirstThick = -3.5; // the first one's position, in phases after the slice
// Variance of a thick slice's profile, in squared slice distances; a box as wide as the distance has 1 / 12.
constexpr double kThick = 1. / 64;

double profileVariance(const SliceSampling& sampling) {
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < sampling.slice.weights.size(); ++i) {
    const double at = sampling.slice.first + static_cast<double>(i);
    mean += sampling.slice.weights[i] * at;
    square += sampling.slice.weights[i] * at * at;
  }
  return (square - mean * mean) / (sampling.phases * sampling.phases);
}

} // namespace

std::vector<float> startWeights(const ConvolutionNetwork::Shape& shape, const SliceSampling& sampling) {
  if (shape.layers != kLayers || (shape.channels != 16 && shape.channels != 32)) return {};
  const bool thick = profileVariance(sampling) > kThick, wide = shape.channels == 32;
  const auto stored =
      thick ? (wide ? std::span<const std::uint16_t>(kThick32) : std::span<const std::uint16_t>(kThick16))
            : (wide ? std::span<const std::uint16_t>(kThin32) : std::span<const std::uint16_t>(kThin16));
  const auto value = [&](std::size_t i) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(stored[i]) << 16);
  };
  const ConvolutionNetwork network(shape, 1);
  const ConvolutionNetwork::Matrix last = network.matrices().back();
  std::vector<float> weights(network.parameters().size(), 0.f);
  for (std::size_t i = 0; i < last.at; ++i)
    weights[i] = value(i);
  for (int q = 0; q < shape.phases; ++q) {
    const double slices = (sampling.firstPhase + q - sampling.centre) / sampling.phases;
    const double at = std::clamp(slices * kPhases - (thick ? kFirstThick : kFirstThin), 0.0, kPhases - 1.0);
    const int below = std::min(static_cast<int>(at), kPhases - 2);
    const auto share = static_cast<float>(at - below);
    for (std::int64_t row = 0; row <= last.rows; ++row) { // the biases follow the weights
      const std::size_t i = last.at + static_cast<std::size_t>(row) * kPhases + below;
      weights[last.at + row * last.columns + q] = value(i) + share * (value(i + 1) - value(i));
    }
  }
  return weights;
}

} // namespace innergs
