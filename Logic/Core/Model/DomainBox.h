#pragma once
#include "Core/Model/GaussianField.h"

#include <algorithm>
#include <cmath>

namespace innergs {

/// The box of a field's domain in the index coordinates of a grid; a field has no value outside it. A
/// domain without voxels is unlimited.
class DomainBox {
public:
  DomainBox(const GridGeometry& domain, const Affine3& indexToWorld)
      : size_(domain.size), limited_(domain.voxelCount() > 0) {
    if (limited_) map_ = inverse(domain.indexToWorld()) * indexToWorld;
  }

  /// Restricts the columns [first, last) of row (y, z) to those inside.
  void clipRow(double y, double z, int& first, int& last) const {
    if (!limited_) return;
    const Vec3 start = map_({0, y, z}), step = column(map_.linear, 0);
    double low = first, high = last - 1;
    for (int a = 0; a < 3; ++a) {
      const double below = -kEdge, above = static_cast<double>(size_[a] - 1) + kEdge;
      if (std::abs(step[a]) < 1e-12) {
        if (start[a] < below || start[a] > above) high = first - 1; // low may be far beyond the row
        continue;
      }
      const double p = (below - start[a]) / step[a], q = (above - start[a]) / step[a];
      low = std::max(low, std::min(p, q));
      high = std::min(high, std::max(p, q));
    }
    const int end = last;
    first = static_cast<int>(std::ceil(std::min(low, static_cast<double>(end))));
    last = std::max(first, static_cast<int>(std::floor(std::max(high, -1.0))) + 1);
  }

  bool contains(const Vec3& index) const {
    if (!limited_) return true;
    const Vec3 x = map_(index);
    for (int a = 0; a < 3; ++a)
      if (!(x[a] >= -kEdge && x[a] <= static_cast<double>(size_[a] - 1) + kEdge)) return false;
    return true;
  }

private:
  static constexpr double kEdge = 0.5 + 1e-4; // a voxel's half width plus rounding of the index maps
  std::array<std::int64_t, 3> size_;
  bool limited_;
  Affine3 map_;
};

} // namespace innergs
