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
constexpr int kLayers = 4, kNarrow = 16, kWide = 32;
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

void setStartWeights(ConvolutionNetwork& network, const SliceSampling& sampling) {
  const ConvolutionNetwork::Shape& shape = network.shape();
  if (shape.layers != kLayers) return;
  const int channels = shape.channels < kWide ? kNarrow : kWide; // learned
  const bool thick = profileVariance(sampling) > kThick, wide = channels == kWide;
  const auto stored =
      thick ? (wide ? std::span<const std::uint16_t>(kThick32) : std::span<const std::uint16_t>(kThick16))
            : (wide ? std::span<const std::uint16_t>(kThin32) : std::span<const std::uint16_t>(kThin16));
  const auto value = [&](std::size_t i) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(stored[i]) << 16);
  };
  const ConvolutionNetwork learned({kPhases, channels, kLayers}, 1);
  const std::vector<ConvolutionNetwork::Matrix> from = learned.matrices(), to = network.matrices();
  // Sets an output's weights from those of the same inputs; the learned outputs ignore further channels.
  const auto set = [&](std::size_t m, std::int64_t output, const auto& learnedWeight) {
    const bool first = m == 0;
    float* parameters = network.parameters().data() + to[m].at + output;
    for (std::int64_t row = 0; row < to[m].rows; ++row) {
      const std::int64_t tap = row / shape.channels, input = row % shape.channels;
      parameters[row * to[m].columns] = first              ? learnedWeight(row)
                                        : input < channels ? learnedWeight(tap * channels + input)
                                                           : 0.f;
    }
    parameters[to[m].rows * to[m].columns] = learnedWeight(from[m].rows); // the bias
  };
  const std::size_t last = to.size() - 1;
  for (std::size_t m = 0; m < last; ++m)
    for (int c = 0; c < channels; ++c)
      set(m, c, [&](std::int64_t row) { return value(from[m].at + row * from[m].columns + c); });
  for (int q = 0; q < shape.phases; ++q) {
    const double slices = (sampling.firstPhase + q - sampling.centre) / sampling.phases;
    const double at = std::clamp(slices * kPhases - (thick ? kFirstThick : kFirstThin), 0.0, kPhases - 1.0);
    const int below = std::min(static_cast<int>(at), kPhases - 2);
    const auto share = static_cast<float>(at - below);
    set(last, q, [&](std::int64_t row) {
      const std::size_t i = from[last].at + row * kPhases + below;
      return value(i) + share * (value(i + 1) - value(i));
    });
  }
}

} // namespace innergs
