#include "Core/Prediction/StartWeights.h"

#include <bit>
#include <cstdint>
#include <span>

namespace innergs {
namespace {

// bfloat16: the upper half of a float.
constexpr std::uint16_t kNarrow[] = {
#include "Core/Prediction/StartWeights16.inc"
};
constexpr std::uint16_t kWide[] = {
#include "Core/Prediction/StartWeights32.inc"
};
constexpr int kLayers = 4;

} // namespace

std::vector<float> startWeights(const ConvolutionNetwork::Shape& shape) {
  if (shape.layers != kLayers || (shape.channels != 16 && shape.channels != 32)) return {};
  const auto stored =
      shape.channels == 16 ? std::span<const std::uint16_t>(kNarrow) : std::span<const std::uint16_t>(kWide);
  std::vector<float> weights;
  weights.reserve(stored.size());
  for (const std::uint16_t upper : stored)
    weights.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(upper) << 16));
  return weights;
}

} // namespace innergs
