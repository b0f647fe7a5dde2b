#pragma once
#include "Core/Image/GridGeometry.h"

#include <optional>
#include <vector>

namespace innergs {

/// For each axis of `points`, the axis that it is parallel to under a map of indices. Nothing unless all are.
std::optional<std::array<int, 3>> parallelAxes(const std::array<std::int64_t, 3>& points, const Affine3& map);

/// Trilinear samples of a grid at the points of another grid whose axes are parallel to its own, in any order
/// and direction. The same values as those of sampleInside(), at a fraction of the time.
class AlignedSampler {
public:
  /// `map`: from the points' indices to the grid's. Nothing unless the axes are parallel.
  static std::optional<AlignedSampler> between(const std::array<std::int64_t, 3>& points, const Affine3& map,
                                               const GridGeometry& grid);

  /// Calls use(i, value) for the points (i, j, k) of a row that lie inside the grid's box of voxel edges.
  /// `voxels`: in the grid's memory order.
  template <class Use>
  void row(const float* voxels, std::int64_t j, std::int64_t k, const Use& use) const {
    const Position &pj = along_[1][j], &pk = along_[2][k];
    if (!pj.inside || !pk.inside) return;
    const float* base = voxels + pj.offset + pk.offset;
    const auto line = [](const float* v, const Position& p) {
      return p.fraction == 0 ? v[0] : v[0] + p.fraction * (v[p.step] - v[0]);
    };
    const auto plane = [&](const float* v, const Position& p, const Position& q) {
      const float a = line(v, p);
      return q.fraction == 0 ? a : a + q.fraction * (line(v + q.step, p) - a);
    };
    if (contiguous_ && pj.fraction == 0 && pk.fraction == 0) {
      const float* v = base + along_[0][first_].offset - first_;
      for (std::int64_t i = first_; i < end_; ++i)
        use(i, v[i]);
    } else if (contiguous_ && pj.fraction == 0) {
      const float* v = base + along_[0][first_].offset - first_;
      for (std::int64_t i = first_; i < end_; ++i)
        use(i, v[i] + pk.fraction * (v[i + pk.step] - v[i]));
    } else {
      for (std::int64_t i = first_; i < end_; ++i) {
        const Position& p = along_[0][i];
        const float* v = base + p.offset;
        const float a = plane(v, p, pj);
        use(i, pk.fraction == 0 ? a : a + pk.fraction * (plane(v + pk.step, p, pj) - a));
      }
    }
  }

private:
  /// Along one axis: the voxel at or below the point, and the share of the next.
  struct Position {
    std::int64_t offset = 0, step = 0; // in the voxels' memory
    float fraction = 0;
    bool inside = false;
  };

  std::array<std::vector<Position>, 3> along_; // the points' axes
  std::int64_t first_ = 0, end_ = 0;           // the points inside, along the first axis
  bool contiguous_ = false;                    // these are voxels that follow each other
};

} // namespace innergs
