#pragma once
#include "Core/Image/Stack.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

constexpr std::int64_t kFewestSamples = 200; // minimum to judge by

/// Samples of an image along an axis: value[n·width + line], inside: 1 where they count.
struct SliceLines {
  std::int64_t length = 0, width = 0;
  std::vector<float> value;
  std::vector<std::uint8_t> inside;
};

/// The voxels of lines through the slices, at a regular subset of the columns, as SliceLines has them.
std::vector<std::int64_t> voxelsAcross(const GridGeometry& stack);
/// Likewise, of lines along in-plane axis 0 or 1, in some of the slices.
std::vector<std::int64_t> voxelsWithin(const GridGeometry& stack, int axis);

/// The image's values at those voxels, `length` along a line.
SliceLines linesAt(std::span<const std::int64_t> voxels, std::int64_t length, std::span<const float> image,
                   std::span<const std::uint8_t> inside);
/// Likewise, its second differences along an in-plane axis, over a quarter of the slice distance.
SliceLines detailAt(std::span<const std::int64_t> voxels, std::int64_t length, const GridGeometry& stack,
                    std::span<const float> image, std::span<const std::uint8_t> inside, int axis);

/// Every factor-th sample, from `phase` on.
SliceLines decimated(const SliceLines& in, std::int64_t factor, std::int64_t phase = 0);
/// Every factor-th row of values [length][width], filtered along the axis by a kernel of odd length.
std::vector<float> sampledRows(const std::vector<float>& values, std::int64_t length, std::int64_t width,
                               std::span<const double> kernel, std::int64_t factor = 1);

/// How often the strongest changes over two slices have an intermediate value in the slice between: 0 for
/// steps (or too few samples), 1 for slopes.
double slopeShare(const SliceLines& slices);
/// Mean squared difference of neighbouring slices over twice their mean square, 1 − correlation; 0: too few
/// samples.
double changeShare(const SliceLines& slices);

} // namespace innergs
