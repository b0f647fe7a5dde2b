#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace innergs {

/// Rows of points start + i·step on a grid, in its index coordinates.
struct PointRow {
  std::array<std::int64_t, 3> size; // of the grid, at least 2 along each axis
  float start[3], step[3];
};

/// Trilinear interpolation along rows of points and its transpose, for one instruction set.
struct TrilinearRows {
  std::string name;
  /// values[i] += weight · volume at point i, for i in [begin, end). values must be NaN where the point lies
  /// outside the grid, and remain so.
  void (*read)(const float* volume, const PointRow& row, float weight, int begin, int end, float* values);
  /// Adds weight · values[i] at point i to the voxels around it, for i in [begin, end), but only to those of
  /// planes [first, last) along the third axis. values must be 0 where the point lies outside the grid.
  void (*add)(const float* values, const PointRow& row, float weight, int begin, int end, std::int64_t first,
              std::int64_t last, float* volume);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<TrilinearRows>& trilinearRows();

} // namespace innergs
