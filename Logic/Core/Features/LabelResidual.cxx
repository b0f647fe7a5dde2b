#include "Core/Features/LabelResidual.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

// A voxel where no class misses the former has no residual; elsewhere, a class that misses less than the
// latter has no entry.
constexpr float kLeastResidual = 1 / 16.f, kLeastEntry = kLeastResidual / 8;

struct Found {
  std::uint32_t voxel, entry;
};

} // namespace

ClassResidual residualOf(const GaussianField& field, const FeatureModel& features, const Labelmap& classes,
                         const FeatureQueryOptions& options) {
  ClassResidual residual;
  const GridGeometry& grid = classes.geometry;
  if (grid.voxelCount() > std::int64_t{0xffffffff}) return residual;
  residual.grid = grid;
  const std::int64_t nx = grid.size[0], ny = grid.size[1];
  std::vector<std::vector<Found>> rows(static_cast<std::size_t>(grid.voxelCount() / nx));
  const auto visit = [&](std::int64_t voxel, std::span<const std::uint16_t> decoded, const float* p) {
    if (!classes.isLabelled(voxel / (nx * ny))) return;
    const std::uint16_t label = classes.voxels[static_cast<std::size_t>(voxel)];
    const auto missed = [&](std::size_t n) { return (decoded[n] == label ? 1.f : 0.f) - p[n]; };
    float most = 0;
    for (std::size_t n = 0; n < decoded.size(); ++n)
      most = std::max(most, std::fabs(missed(n)));
    if (most < kLeastResidual) return;
    for (std::size_t n = 0; n < decoded.size(); ++n)
      if (const float m = missed(n); std::fabs(m) >= kLeastEntry)
        rows[static_cast<std::size_t>(voxel / nx)].push_back(
            {static_cast<std::uint32_t>(voxel), ClassResidual::packed(decoded[n], m)});
  };
  const auto collect = [&](std::int64_t firstPlane, std::int64_t lastPlane) {
    for (std::int64_t r = firstPlane * ny; r < lastPlane * ny; ++r) {
      for (const Found& found : rows[static_cast<std::size_t>(r)]) {
        if (residual.voxels.empty() || residual.voxels.back() != found.voxel) {
          residual.voxels.push_back(found.voxel);
          residual.ends.push_back(0);
        }
        residual.entries.push_back(found.entry);
        residual.ends.back() = static_cast<std::uint32_t>(residual.entries.size());
      }
      rows[static_cast<std::size_t>(r)] = {};
    }
  };
  decodeGrid(field, features, grid, options, visit, collect);
  return residual;
}

} // namespace innergs
