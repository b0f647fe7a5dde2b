#include "Core/Alignment/EdgeBlending.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// A scan with what is not observed missing.
struct Seen {
  Volume image;
  Affine3 toIndex;
};

/// 0 at and beyond the faces of a grid, 1 from `width` (mm) before them on.
double depthShare(const GridGeometry& grid, const Vec3& index, double width) {
  return std::clamp(depthInside(grid, index) / width, 0.0, 1.0);
}

} // namespace

void blendEdges(std::span<Stack> scans, std::span<const std::size_t> part, double width, ThreadPool& pool) {
  std::vector<Seen> seen;
  for (const std::size_t s : part) {
    if (!scans[s].poses.empty()) return;
    const Stack& scan = scans[s];
    seen.emplace_back(observedImage(scan), inverse(scan.image.geometry.indexToWorld()));
  }
  for (std::size_t p = 0; p < part.size(); ++p) {
    Volume& own = scans[part[p]].image;
    const auto& n = own.geometry.size;
    const Affine3 toWorld = own.geometry.indexToWorld();
    pool.run(n[1] * n[2], [&](std::int64_t row) {
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const Vec3 index{static_cast<double>(i), static_cast<double>(row % n[1]),
                         static_cast<double>(row / n[1])};
        const double share = depthShare(own.geometry, index, width);
        if (share >= 1) continue;
        const Vec3 world = toWorld(index);
        double sum = 0, weights = 0, most = 0;
        for (std::size_t o = 0; o < seen.size(); ++o) {
          if (o == p) continue;
          const Volume& image = seen[o].image;
          const Vec3 at = seen[o].toIndex(world);
          const double weight = depthShare(image.geometry, at, width);
          float value;
          if (!(weight > share) || !sampleInside(image.geometry, image.voxels.data(), at, value) ||
              !std::isfinite(value))
            continue;
          sum += weight * value;
          weights += weight;
          most = std::max(most, weight);
        }
        if (weights <= 0) continue;
        float& voxel = own.voxels[static_cast<std::size_t>(row * n[0] + i)];
        voxel = static_cast<float>(share / most * voxel + (1 - share / most) * sum / weights);
      }
    });
  }
}

} // namespace innergs
