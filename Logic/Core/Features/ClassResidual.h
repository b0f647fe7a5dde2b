#pragma once
#include "Core/Image/GridGeometry.h"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// What rendered features miss of the labels that they were learned from: the share of a class in a voxel of
/// the labels' grid minus its decoded probability, as a field's residual grid is what the Gaussians miss
/// of the data. Between voxels it is interpolated linearly and added to the probabilities.
struct ClassResidual {
  struct Entry { // as it is packed: the class in the lower 16 bits, the share × kOne above
    std::uint16_t c = 0;
    std::int16_t share = 0;
  };
  static constexpr float kOne = 32767;

  GridGeometry grid;                  // LPS mm
  std::vector<std::uint32_t> voxels;  // that have a residual, ascending, in memory order of Volume
  std::vector<std::uint32_t> ends;    // per such voxel: past its last entry
  std::vector<std::uint32_t> entries; // packed

  static std::uint32_t packed(std::uint16_t c, float share);
  static Entry unpacked(std::uint32_t entry) {
    return {static_cast<std::uint16_t>(entry & 0xffff),
            std::bit_cast<std::int16_t>(static_cast<std::uint16_t>(entry >> 16))};
  }
  bool empty() const { return voxels.empty(); }
};

/// Throws Error(FileFormat) for a residual that cannot be evaluated.
void checkResidual(const ClassResidual& residual, int classes);

/// A residual at continuous indices of another grid.
class ClassResidualSampler {
public:
  ClassResidualSampler(const ClassResidual& residual, const Affine3& indexToWorld);

  /// Adds the residual at an index of that grid to the probabilities of some classes, which stay
  /// probabilities; outside the residual's grid nothing changes.
  void add(const Vec3& index, std::span<const std::uint16_t> classes, float* probabilities) const;

private:
  const ClassResidual& residual_;
  Affine3 map_;
  std::vector<std::uint64_t> has_;    // a bit per voxel of the grid
  std::vector<std::uint32_t> before_; // voxels with a residual before each word of them
};

} // namespace innergs
