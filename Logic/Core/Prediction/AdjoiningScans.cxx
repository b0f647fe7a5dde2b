#include "Core/Prediction/AdjoiningScans.h"

#include "Core/Image/CubicConvolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr double kParallel = 0.985; // cosine between slice normals, for slices of neighbours
constexpr double kFadedSlices = 2;  // slice distances before a scan's faces
constexpr float kLeastWeight = 1e-4F;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

bool parallel(const GridGeometry& a, const GridGeometry& b) {
  return std::abs(dot(column(a.direction, 2), column(b.direction, 2))) >= kParallel;
}

bool observedAt(const Stack& scan, const Vec3& index) {
  const auto& n = scan.image.geometry.size;
  std::int64_t v = 0, step = 1;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t at = std::llround(index[a]);
    if (at < 0 || at >= n[a]) return false;
    v += step * at;
    step *= n[a];
  }
  return isKnown(scan, v);
}

} // namespace

Stack continued(std::span<const Stack> scans, std::size_t which, int most, ThreadPool& pool) {
  const Stack& scan = scans[which];
  const GridGeometry& g = scan.image.geometry;
  const std::int64_t row = g.size[0], plane = row * g.size[1];
  std::vector<Volume> others;
  std::vector<Affine3> maps; // from the scan's indices
  for (std::size_t s = 0; s < scans.size(); ++s) {
    if (s == which || !parallel(scans[s].image.geometry, g)) continue;
    others.push_back(observedImage(scans[s]));
    maps.push_back(inverse(others.back().geometry.indexToWorld()) * g.indexToWorld());
  }
  const auto beyond = [&](std::int64_t k) {
    std::vector<float> slice(static_cast<std::size_t>(plane), kNaN);
    pool.run(g.size[1], [&](std::int64_t j) {
      for (std::int64_t i = 0; i < row; ++i) {
        const Vec3 at{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        float sum = 0, count = 0, value = 0;
        for (std::size_t o = 0; o < others.size(); ++o) {
          if (!sampleInside(others[o].geometry, others[o].voxels.data(), maps[o](at), value) ||
              !std::isfinite(value))
            continue;
          sum += value;
          ++count;
        }
        if (count > 0) slice[j * row + i] = sum / count;
      }
    });
    return slice;
  };
  /// Slices from the face on, up to the last that is known well enough.
  const auto side = [&](std::int64_t first, std::int64_t step) {
    std::vector<std::vector<float>> slices;
    std::size_t known = 0;
    for (int n = 0; n < most; ++n) {
      slices.push_back(beyond(first + n * step));
      const auto finite =
          std::count_if(slices.back().begin(), slices.back().end(), [](float v) { return std::isfinite(v); });
      if (2 * finite >= plane) known = slices.size();
    }
    slices.resize(known);
    return slices;
  };
  const auto before = side(-1, -1), after = side(g.size[2], 1);
  Stack longer = scan;
  longer.thickness = scan.thickness > 0 ? scan.thickness : g.spacing[2];
  longer.image.voxels.clear();
  const auto append = [&](const std::vector<float>& values) {
    longer.image.voxels.insert(longer.image.voxels.end(), values.begin(), values.end());
  };
  std::for_each(before.rbegin(), before.rend(), append);
  append(scan.image.voxels);
  std::for_each(after.begin(), after.end(), append);
  longer.image.geometry.size[2] += static_cast<std::int64_t>(before.size() + after.size());
  longer.image.geometry.origin = g.indexToWorld()({0, 0, -static_cast<double>(before.size())});
  if (!scan.observed.empty()) {
    const auto added = [&](const auto& slices) { return slices.size() * static_cast<std::size_t>(plane); };
    longer.observed.insert(longer.observed.begin(), added(before), 1);
    longer.observed.insert(longer.observed.end(), added(after), 1);
  }
  return longer;
}

JoinedVolumes::JoinedVolumes(const GridGeometry& grid)
    : sum_{grid, std::vector<float>(static_cast<std::size_t>(grid.voxelCount()), 0.F)},
      weights_(sum_.voxels.size(), 0.F) {}

void JoinedVolumes::add(const Volume& volume, const Stack& scan, ThreadPool& pool) {
  const auto& n = sum_.geometry.size;
  const Affine3 toWorld = sum_.geometry.indexToWorld();
  const Affine3 toVolume = inverse(volume.geometry.indexToWorld()) * toWorld,
                toScan = inverse(scan.image.geometry.indexToWorld()) * toWorld;
  const double fade = kFadedSlices * scan.image.geometry.spacing[2];
  const CubicConvolution& cubic = cubicConvolutions().front();
  const auto inside = [&](const Vec3& index) {
    for (int a = 0; a < 3; ++a)
      if (!(index[a] >= -0.5 - kIndexRounding &&
            index[a] <= static_cast<double>(volume.geometry.size[a]) - 0.5 + kIndexRounding))
        return false;
    return true;
  };
  pool.run(n[1] * n[2], [&](std::int64_t line) {
    const Vec3 start{0, static_cast<double>(line % n[1]), static_cast<double>(line / n[1])};
    const Vec3 first = toVolume(start), step = toVolume.linear * Vec3{1, 0, 0};
    std::int64_t begin = 0, end = n[0];
    while (begin < end && !inside(first + static_cast<double>(begin) * step))
      ++begin;
    while (end > begin && !inside(first + static_cast<double>(end - 1) * step))
      --end;
    if (begin == end) return;
    std::vector<float> values(static_cast<std::size_t>(n[0]), 0.F);
    cubic.add(volume, first, step, kKeys, static_cast<int>(begin), static_cast<int>(end), values.data());
    for (std::int64_t i = begin; i < end; ++i) {
      if (!std::isfinite(values[i])) continue;
      const Vec3 at = toScan({static_cast<double>(i), start[1], start[2]});
      const double depth = std::clamp(depthInside(scan.image.geometry, at) / fade, 0.0, 1.0);
      const float weight = kLeastWeight + (observedAt(scan, at) ? static_cast<float>(depth) : 0.F);
      sum_.voxels[line * n[0] + i] += weight * values[i];
      weights_[line * n[0] + i] += weight;
    }
  });
}

Volume JoinedVolumes::take() {
  for (std::size_t v = 0; v < weights_.size(); ++v)
    sum_.voxels[v] = weights_[v] > 0 ? sum_.voxels[v] / weights_[v] : kNaN;
  weights_ = {};
  return std::move(sum_);
}

} // namespace innergs
