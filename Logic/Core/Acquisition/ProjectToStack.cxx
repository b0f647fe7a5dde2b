#include "Core/Acquisition/ProjectToStack.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Image/AlignedSampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace innergs {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Sub-planes no further apart than the volume's own spacing along the normal: exact for a box that spans
/// whole voxels.
ProfileQuadrature subPlanes(const Stack& stack, const GridGeometry& volume) {
  const Vec3 along = transpose(volume.direction) * column(stack.image.geometry.direction, 2);
  const double step =
      1 / norm({along[0] / volume.spacing[0], along[1] / volume.spacing[1], along[2] / volume.spacing[2]});
  return profileQuadrature(stack.profile, effectiveThickness(stack), step);
}

/// Whether a continuous index lies on an axis of this many voxels, their outer edges included.
bool isOn(double index, std::int64_t voxels) {
  return index >= -0.5 - kIndexRounding && index <= static_cast<double>(voxels) - 0.5 + kIndexRounding;
}

/// What one slice sees along its normal: a weighted sum of voxels that follow each other.
struct Taps {
  std::int64_t first = 0;
  std::vector<float> weights; // their sum is 1; none: all sub-planes lie outside
};

/// planes: continuous indices of the sub-planes on an axis of `count` voxels.
Taps tapsOf(std::span<const double> planes, const std::vector<double>& planeWeights, std::int64_t count,
            float keys) {
  std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
  std::int64_t first = count, end = 0;
  double total = 0;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    if (!isOn(planes[p], count)) continue;
    const double at = std::clamp(planes[p], 0.0, static_cast<double>(count - 1));
    const auto low = static_cast<std::int64_t>(at + kIndexRounding);
    const double above = at - static_cast<double>(low), f = above < kIndexRounding ? 0 : above;
    const std::array<double, 4> weights = keysWeights<double>(f, keys);
    for (std::int64_t t = 0; t < 4; ++t) {
      if (weights[t] == 0) continue;
      const std::int64_t voxel = std::clamp<std::int64_t>(low - 1 + t, 0, count - 1);
      sums[voxel] += planeWeights[p] * weights[t];
      first = std::min(first, voxel);
      end = std::max(end, voxel + 1);
    }
    total += planeWeights[p];
  }
  Taps taps{first, {}};
  for (std::int64_t v = first; v < end; ++v)
    taps.weights.push_back(static_cast<float>(sums[v] / total));
  return taps;
}

/// projectToStack() onto slices whose pixels lie on rows of voxels along the normal: nothing but these rows
/// is read. Nothing for other slices.
std::optional<std::vector<float>> projectAligned(const Volume& volume, const Stack& stack,
                                                 const ProfileQuadrature& planes, ThreadPool& pool,
                                                 float keys) {
  const GridGeometry& g = stack.image.geometry;
  const auto& n = volume.geometry.size;
  const Affine3 toVolume = inverse(volume.geometry.indexToWorld());
  const Affine3 map = toVolume * g.indexToWorld();
  const auto axes = parallelAxes(g.size, map);
  if (!axes) return {};
  const std::int64_t strides[] = {1, n[0], n[0] * n[1]};
  std::array<std::vector<std::int64_t>, 2> offsets; // in the volume's memory; below 0: outside
  for (int b = 0; b < 2; ++b)
    for (std::int64_t i = 0; i < g.size[b]; ++i) {
      const int a = (*axes)[b];
      const double x = map.linear[a][b] * static_cast<double>(i) + map.offset[a], voxel = std::round(x);
      if (std::abs(x - voxel) >= kIndexRounding) return {};
      offsets[b].push_back(isOn(x, n[a]) ? static_cast<std::int64_t>(voxel) * strides[a] : -1);
    }
  const int normal = (*axes)[2];
  const double perMm = (toVolume.linear * column(g.direction, 2))[normal];
  std::vector<Taps> taps(static_cast<std::size_t>(g.size[2]));
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    std::vector<double> at;
    for (const double offset : planes.offset)
      at.push_back(map.linear[normal][2] * static_cast<double>(k) + map.offset[normal] + perMm * offset);
    taps[k] = tapsOf(at, planes.weight, n[normal], keys);
  }
  const std::vector<std::int64_t>& columns = offsets[0];
  const auto isInside = [](std::int64_t offset) { return offset >= 0; };
  const auto begin = std::find_if(columns.begin(), columns.end(), isInside) - columns.begin();
  const auto end = std::find_if_not(columns.begin() + begin, columns.end(), isInside) - columns.begin();
  const bool contiguous = (*axes)[0] == 0 && (end - begin < 2 || columns[begin + 1] == columns[begin] + 1);
  std::vector<float> out(static_cast<std::size_t>(g.voxelCount()), kNaN);
  pool.run(g.size[1] * g.size[2], [&](std::int64_t row) {
    const std::int64_t j = row % g.size[1], k = row / g.size[1];
    const Taps& seen = taps[k];
    if (offsets[1][j] < 0 || seen.weights.empty() || begin == end) return;
    std::vector<float> sums(static_cast<std::size_t>(end - begin), 0.f);
    for (std::size_t t = 0; t < seen.weights.size(); ++t) {
      const float weight = seen.weights[t];
      if (weight == 0) continue;
      const float* from = volume.voxels.data() + offsets[1][j] +
                          strides[normal] * (seen.first + static_cast<std::int64_t>(t));
      if (contiguous) {
        from += columns[begin];
        for (std::int64_t i = 0; i < end - begin; ++i)
          sums[i] += weight * from[i];
      } else {
        for (std::int64_t i = 0; i < end - begin; ++i)
          sums[i] += weight * from[columns[begin + i]];
      }
    }
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t v = row * g.size[0] + i;
      if (stack.observed.empty() || stack.observed[v]) out[v] = sums[i - begin];
    }
  });
  return out;
}

/// projectToStack() through the middles of the pixels.
std::vector<float> projectToPoints(const Volume& volume, const Stack& stack, ThreadPool& pool, float keys) {
  const GridGeometry& g = stack.image.geometry;
  const auto& n = volume.geometry.size;
  const Affine3 toVolume = inverse(volume.geometry.indexToWorld());
  const ProfileQuadrature planes = subPlanes(stack, volume.geometry);
  if (stack.poses.empty())
    if (auto aligned = projectAligned(volume, stack, planes, pool, keys)) return std::move(*aligned);
  std::vector<float> out(static_cast<std::size_t>(g.voxelCount()));
  const CubicConvolution& cubic = cubicConvolutions().front();
  pool.run(g.size[1] * g.size[2], [&](std::int64_t row) {
    const std::int64_t j = row % g.size[1], k = row / g.size[1];
    const Affine3 pose = stack.poses.empty() ? Affine3{} : stack.poses[k];
    const Affine3 stackToVolume = toVolume * pose * g.indexToWorld();
    const Vec3 normal = (toVolume.linear * pose.linear) * column(g.direction, 2); // voxels per mm
    const Vec3 first = stackToVolume({0, static_cast<double>(j), static_cast<double>(k)}),
               step = column(stackToVolume.linear, 0);
    const auto width = static_cast<int>(g.size[0]);
    std::vector<double> sums(static_cast<std::size_t>(width), 0.0), weights = sums;
    std::vector<float> values(static_cast<std::size_t>(width));
    for (std::size_t p = 0; p < planes.offset.size(); ++p) {
      const Vec3 start = first + planes.offset[p] * normal;
      std::fill(values.begin(), values.end(), 0.F);
      cubic.add(volume, start, step, keys, 0, width, values.data());
      for (int i = 0; i < width; ++i) {
        const Vec3 x = start + static_cast<double>(i) * step;
        if (!(isOn(x[0], n[0]) && isOn(x[1], n[1]) && isOn(x[2], n[2]))) continue;
        sums[i] += planes.weight[p] * values[i];
        weights[i] += planes.weight[p];
      }
    }
    for (int i = 0; i < width; ++i) {
      const auto v = static_cast<std::size_t>(row * width + i);
      const bool seen = weights[i] > 0 && (stack.observed.empty() || stack.observed[v]);
      out[v] = seen ? static_cast<float>(sums[i] / weights[i]) : kNaN;
    }
  });
  return out;
}

} // namespace

std::vector<float> projectToStack(const Volume& volume, const Stack& stack, ThreadPool& pool, float keys) {
  const GridGeometry& g = stack.image.geometry;
  const std::vector<PixelPoint> points = pixelPoints(
      pixelQuadrature(stack.profile, stack.pixelWidth, volume.geometry.finestSpacing()), g.spacing);
  if (points.size() == 1) return projectToPoints(volume, stack, pool, keys);
  std::vector<float> sums(static_cast<std::size_t>(g.voxelCount()), 0.f), weights = sums;
  Stack moved = stack;
  for (const PixelPoint& point : points) {
    moved.image.geometry.origin = g.indexToWorld()({point.offset[0], point.offset[1], 0});
    const std::vector<float> seen = projectToPoints(volume, moved, pool, keys);
    const auto weight = static_cast<float>(point.weight);
    for (std::size_t v = 0; v < seen.size(); ++v) {
      if (!std::isfinite(seen[v])) continue;
      sums[v] += weight * seen[v];
      weights[v] += weight;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v)
    sums[v] = weights[v] > 0 ? sums[v] / weights[v] : kNaN;
  return sums;
}

} // namespace innergs
