#include "Core/Features/Labelmap.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Whether each slice along an axis contains a label.
std::vector<std::uint8_t> usedSlices(const Labelmap& labels, int axis) {
  const auto& n = labels.geometry.size;
  std::vector<std::uint8_t> used(static_cast<std::size_t>(n[axis]), 0);
  std::size_t at = 0;
  std::int64_t index[3];
  for (index[2] = 0; index[2] < n[2]; ++index[2])
    for (index[1] = 0; index[1] < n[1]; ++index[1])
      for (index[0] = 0; index[0] < n[0]; ++index[0], ++at)
        if (labels.voxels[at] != 0) used[static_cast<std::size_t>(index[axis])] = 1;
  return used;
}

std::int64_t emptyBetween(const std::vector<std::uint8_t>& used) {
  const auto first = std::find(used.begin(), used.end(), 1);
  const auto last = std::find(used.rbegin(), used.rend(), 1).base();
  return first < last ? std::count(first, last, 0) : 0;
}

Labelmap withSliceAxis(const Labelmap& labels, int axis) {
  Labelmap out{innergs::withSliceAxis(labels.geometry, axis), {}, {}};
  const std::array<int, 3> from = axesWithSliceAxis(axis);
  const auto& n = labels.geometry.size;
  const std::int64_t stride[3] = {1, n[0], n[0] * n[1]};
  out.voxels.reserve(labels.voxels.size());
  const auto& m = out.geometry.size;
  for (std::int64_t k = 0; k < m[2]; ++k)
    for (std::int64_t j = 0; j < m[1]; ++j)
      for (std::int64_t i = 0; i < m[0]; ++i)
        out.voxels.push_back(labels.voxels[static_cast<std::size_t>(
            i * stride[from[0]] + j * stride[from[1]] + k * stride[from[2]])]);
  return out;
}

} // namespace

Labelmap labelmapOf(const Volume& volume) {
  Labelmap labels{volume.geometry, {}, {}};
  labels.voxels.reserve(volume.voxels.size());
  for (const float value : volume.voxels) {
    if (!(value >= 0 && value <= 65535) || value != std::floor(value))
      throw Error(ErrorCode::FileFormat,
                  "The labels hold the value " + numberText(value) +
                      ", which is not a label from 0 to 65535; give a labelmap, not a scan.");
    labels.voxels.push_back(static_cast<std::uint16_t>(value));
  }
  return labels;
}

Labelmap withSparseSlices(const Labelmap& labels) {
  int axis = 2;
  std::int64_t most = 0;
  for (const int candidate : {2, 1, 0}) {
    const std::int64_t empty = emptyBetween(usedSlices(labels, candidate));
    if (empty > most) {
      most = empty;
      axis = candidate;
    }
  }
  if (most == 0) return labels;
  Labelmap out = axis == 2 ? labels : withSliceAxis(labels, axis);
  out.labelled = usedSlices(out, 2);
  return out;
}

Labelmap resampled(const Labelmap& labels, const GridGeometry& geometry) {
  Labelmap out{geometry, {}, {}};
  out.voxels.assign(static_cast<std::size_t>(geometry.voxelCount()), 0);
  const Affine3 map = inverse(labels.geometry.indexToWorld()) * geometry.indexToWorld();
  const auto& n = labels.geometry.size;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < geometry.size[0]; ++i, ++at) {
        const Vec3 x = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        std::int64_t v[3];
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
          v[a] = static_cast<std::int64_t>(
              std::floor(std::clamp(x[a], -2.0, static_cast<double>(n[a]) + 2) + 0.5));
          inside = inside && v[a] >= 0 && v[a] < n[a];
        }
        if (inside)
          out.voxels[at] = labels.voxels[static_cast<std::size_t>(v[0] + n[0] * (v[1] + n[1] * v[2]))];
      }
  return out;
}

} // namespace innergs
