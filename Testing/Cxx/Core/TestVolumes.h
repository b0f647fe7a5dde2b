#pragma once
#include "Core/Image/Stack.h"
#include "Core/Image/Volume.h"

#include <cstdint>
#include <random>
#include <utility>

namespace innergs::testing {

/// A rotation by `angle` about the axis (1, 2, 3)/√14, with the third column reflected if left-handed.
inline Mat3 obliqueDirection(double angle, bool leftHanded = false) {
  const double n = std::sqrt(14.0), a[3] = {1 / n, 2 / n, 3 / n}, c = std::cos(angle), s = std::sin(angle);
  Mat3 r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      r[i][j] = (i == j ? c : 0) + (1 - c) * a[i] * a[j];
  r[0][1] -= s * a[2], r[1][0] += s * a[2];
  r[0][2] += s * a[1], r[2][0] -= s * a[1];
  r[1][2] -= s * a[0], r[2][1] += s * a[0];
  if (leftHanded)
    for (int i = 0; i < 3; ++i)
      r[i][2] = -r[i][2];
  return r;
}

inline GridGeometry grid(std::int64_t nx, std::int64_t ny, std::int64_t nz, const Vec3& spacing = {1, 1, 1},
                         const Vec3& origin = {0, 0, 0}, const Mat3& direction = {}) {
  return {{nx, ny, nz}, origin, spacing, direction};
}

/// 9×11×7 points in the frame of a volume's grid: axes permuted, reversed where asked, and shifted. step,
/// origin: voxels of the volume.
inline GridGeometry pointsOver(const GridGeometry& volume, const std::array<int, 3>& axes, const Vec3& step,
                               const Vec3& origin) {
  GridGeometry points;
  points.size = {9, 11, 7};
  for (int b = 0; b < 3; ++b) {
    points.spacing[b] = std::abs(step[b]) * volume.spacing[axes[b]];
    for (int row = 0; row < 3; ++row)
      points.direction[row][b] = std::copysign(1.0, step[b]) * volume.direction[row][axes[b]];
  }
  points.origin = volume.indexToWorld()(origin);
  return points;
}

/// value(i, j, k) at every voxel.
template <typename Function>
Volume volumeOf(const GridGeometry& geometry, Function value) {
  Volume volume{geometry, {}};
  for (std::int64_t k = 0; k < geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < geometry.size[0]; ++i)
        volume.voxels.push_back(static_cast<float>(value(i, j, k)));
  return volume;
}

/// value(LPS position) at every voxel.
template <typename Function>
Volume volumeInSpace(const GridGeometry& geometry, Function value) {
  return volumeOf(geometry, [&, map = geometry.indexToWorld()](auto i, auto j, auto k) {
    return value(map({double(i), double(j), double(k)}));
  });
}

/// The LPS positions of all voxels.
inline std::vector<Vec3> pointsOf(const GridGeometry& geometry) {
  std::vector<Vec3> points;
  volumeInSpace(geometry, [&](const Vec3& x) {
    points.push_back(x);
    return 0;
  });
  return points;
}

/// The voxels whose LPS position is inside.
template <typename Predicate>
Mask maskInSpace(const GridGeometry& geometry, Predicate inside) {
  const std::vector<float> voxels = volumeInSpace(geometry, inside).voxels;
  return {geometry, {voxels.begin(), voxels.end()}};
}

/// A scan that shows points.
inline Stack pointStack(Volume image) {
  Stack stack;
  stack.image = std::move(image);
  stack.profile = SliceProfile::Point;
  return stack;
}

/// Marks slices as not observed, and all others as observed.
inline void holdOut(Stack& stack, const std::vector<std::int64_t>& slices) {
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  stack.observed.assign(stack.image.voxels.size(), 1);
  for (const std::int64_t k : slices)
    std::fill_n(stack.observed.begin() + k * plane, plane, std::uint8_t{0});
}

inline Volume randomVolume(const GridGeometry& geometry, double low, double high, std::uint64_t seed = 1) {
  std::mt19937_64 engine(seed);
  return volumeOf(geometry,
                  [&](auto, auto, auto) { return low + (high - low) * (double(engine() >> 11) * 0x1p-53); });
}

/// Texture with a spectrum of about 1/f²: octaves of equal variance, random on grids of 1.7 to 13.6 voxels
/// and interpolated between their points.
inline Volume texture(const GridGeometry& geometry, std::uint64_t seed = 1) {
  std::vector<Volume> octaves;
  std::vector<double> cells;
  for (double cell = 1.7; cell < 16; cell *= 2) {
    GridGeometry grid = geometry;
    for (std::int64_t& n : grid.size)
      n = static_cast<std::int64_t>(static_cast<double>(n) / cell) + 2;
    octaves.push_back(randomVolume(grid, -1, 1, seed * 100 + octaves.size()));
    cells.push_back(cell);
  }
  return volumeOf(geometry, [&](auto i, auto j, auto k) {
    double sum = 0;
    for (std::size_t n = 0; n < octaves.size(); ++n)
      sum += sampleLinear(octaves[n], {double(i) / cells[n], double(j) / cells[n], double(k) / cells[n]});
    return 100 + 10 * sum;
  });
}

/// A head-like phantom: a bright ellipsoid with smooth texture and a hollow, zero outside; values 0…200.
inline Volume phantom(const GridGeometry& geometry) {
  const Vec3 centre = geometry.centre(), extent = geometry.extent();
  return volumeInSpace(geometry, [&](const Vec3& x) {
    const Vec3 d = transpose(geometry.direction) * (x - centre);
    double r2 = 0;
    for (int a = 0; a < 3; ++a)
      r2 += std::pow(d[a] / (0.42 * extent[a]), 2);
    if (r2 > 1) return 0.0;
    if (r2 < 0.04) return 10.0;
    return 130 + 40 * std::sin(0.25 * x[0]) * std::cos(0.3 * x[1]) + 30 * std::sin(0.35 * x[2] + 0.1 * x[0]);
  });
}

} // namespace innergs::testing
