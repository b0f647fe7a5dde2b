#pragma once
#include "Core/Image/Linear.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// Nodes in the model frame, each with a displacement (mm) and a rotation, interpolated trilinearly and
/// constant beyond the outermost ones. A rotation is r = 2·tan(θ/2)·axis, the Rodrigues vector: its
/// quaternion is (1, r/2), not normalised, so that gradients through it are linear. Six values per node:
/// displacement, rotation.
struct MotionGrid {
  static constexpr int kValues = 6;

  std::array<std::int64_t, 3> size{0, 0, 0}; // nodes along x, y, z; at least 2 each
  Vec3 origin{0, 0, 0}, spacing{1, 1, 1};    // mm, model frame

  std::int64_t nodes() const { return size[0] * size[1] * size[2]; }

  /// The position of a point: the cell's first node, and the fraction within the cell along each axis.
  struct Place {
    std::uint32_t node = 0;
    float fraction[3] = {};
  };
  Place place(const float* point) const;

  /// The eight nodes around a position and their weights.
  struct Corners {
    std::uint32_t node[8];
    float weight[8];
  };
  Corners corners(const Place& place) const;

  /// values: kValues per node.
  std::array<float, kValues> at(const Place& place, std::span<const float> values) const;
};

/// A grid with nodes about every `spacing` mm over a box (mm, model frame).
MotionGrid motionGridOver(const Vec3& low, const Vec3& high, const Vec3& spacing);

/// Σ over axes and nodes of squared second differences between neighbouring nodes, with 1 rad of rotation
/// counting as `rotationScale` mm; adds its gradient times `weight`. Zero for anything linear in space.
double addBending(const MotionGrid& grid, std::span<const float> values, double rotationScale, double weight,
                  std::span<float> gradient);

} // namespace innergs
