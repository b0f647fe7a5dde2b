#include "Core/Alignment/TrilinearRowsScalar.h"

#include <algorithm>

namespace innergs {
namespace {

/// The voxel below a point of a row along each axis, and how far the point lies above it.
struct Cell {
  std::int64_t low[3];
  float above[3];

  Cell(const PointRow& row, int i) {
    for (int a = 0; a < 3; ++a) {
      const float at = row.start[a] + static_cast<float>(i) * row.step[a];
      const float x = at >= 0 ? std::min(at, static_cast<float>(row.size[a] - 1)) : 0;
      low[a] = std::min(static_cast<std::int64_t>(x), row.size[a] - 2);
      above[a] = x - static_cast<float>(low[a]);
    }
  }
};

void read(const float* volume, const PointRow& row, float weight, int begin, int end, float* values) {
  const std::int64_t dy = row.size[0], dz = row.size[0] * row.size[1];
  for (int i = begin; i < end; ++i) {
    const Cell cell(row, i);
    const float fx = cell.above[0], fy = cell.above[1], fz = cell.above[2];
    const float* p = volume + cell.low[0] + dy * cell.low[1] + dz * cell.low[2];
    const float a = p[0] + fx * (p[1] - p[0]), b = p[dy] + fx * (p[dy + 1] - p[dy]);
    p += dz;
    const float c = p[0] + fx * (p[1] - p[0]), d = p[dy] + fx * (p[dy + 1] - p[dy]);
    const float e = a + fy * (b - a), f = c + fy * (d - c);
    values[i] += weight * (e + fz * (f - e));
  }
}

void add(const float* values, const PointRow& row, float weight, int begin, int end, std::int64_t first,
         std::int64_t last, float* volume) {
  const std::int64_t dy = row.size[0], dz = row.size[0] * row.size[1];
  for (int i = begin; i < end; ++i) {
    const float r = weight * values[i];
    if (r == 0) continue;
    const Cell cell(row, i);
    const float fx = cell.above[0], fy = cell.above[1], fz = cell.above[2];
    float* p = volume + cell.low[0] + dy * cell.low[1] + dz * cell.low[2];
    const auto plane = [&](float* to, float w) {
      const float a = w * (1 - fy), b = w * fy;
      to[0] += a * (1 - fx);
      to[1] += a * fx;
      to[dy] += b * (1 - fx);
      to[dy + 1] += b * fx;
    };
    if (cell.low[2] >= first && cell.low[2] < last) plane(p, r * (1 - fz));
    if (cell.low[2] + 1 >= first && cell.low[2] + 1 < last) plane(p + dz, r * fz);
  }
}

} // namespace

TrilinearRows scalarTrilinearRows() {
  return {"scalar", read, add};
}

} // namespace innergs
