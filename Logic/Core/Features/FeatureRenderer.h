#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"
#include "Core/Render/Candidates.h"
#include "Core/Render/Contribution.h"
#include "Core/Render/Tiles.h"

namespace innergs {

/// The voxels [first, last) of a row along x.
struct RowPart {
  int first = 0, last = 0;
};

/// The Gaussians of a field on one grid, with the contribution of each to every voxel.
class FeatureRenderer {
public:
  FeatureRenderer(const GaussianField& field, SampleGrid grid, ThreadPool& pool);

  const SampleGrid& grid() const { return grid_; }

  /// F = Σ w p f / (Σ w p + ε), normalised whatever the field's blending; latents: [Gaussian][channel], out:
  /// [plane][row][column][channel]. parts: the voxels wanted in each row, [plane][row]; others are undefined.
  /// Empty: all.
  void render(std::span<const float> latents, int channels, float* out, std::span<const RowPart> parts = {});

  /// Calls visit(voxel, w·p) for all voxels of one Gaussian, row by row; voxel: in memory order of
  /// nx×ny×planes.
  template <class Visit>
  void forEachVoxel(std::int64_t gaussian, Visit&& visit) const {
    visitTile(gaussian, {0, grid_.ny, 0, grid_.planes()}, visit);
  }

private:
  GridView view() const { return {grid_.nx, grid_.ny, grid_.planes(), grid_.stride(), grid_.z.data()}; }
  template <class Visit>
  void visitTile(std::int64_t gaussian, const TileRange& tile, Visit&& visit) const {
    forEachRow(gaussian, tile, [&](int k, int y, int x0, int x1) {
      const std::int64_t row =
          static_cast<std::int64_t>(grid_.nx) * (y + static_cast<std::int64_t>(grid_.ny) * k);
      forRow(gaussian, k, y, x0, x1, [&](int x, float p) { visit(x + row, p); });
    });
  }
  template <class Visit>
  void forEachRow(std::int64_t gaussian, const TileRange& tile, Visit&& visit) const {
    forEachCandidateRow<Selection::Exact>(projected_[static_cast<std::size_t>(gaussian)], view(), tile,
                                          visit);
  }
  /// visit(x, w·p)
  template <class Visit>
  void forRow(std::int64_t gaussian, int k, int y, int x0, int x1, Visit&& visit) const {
    const Projected& g = projected_[static_cast<std::size_t>(gaussian)];
    Contribution c;
    for (int x = x0; x < x1; ++x) {
      const double index[3] = {static_cast<double>(x), static_cast<double>(y), grid_.z[k]};
      if (contributionAt(g, index, c)) visit(x, c.p);
    }
  }

  SampleGrid grid_;
  ThreadPool& pool_;
  float epsilon_;
  std::vector<Projected> projected_;
};

} // namespace innergs
