#include "SweepVolumes.h"

#include "IO/VolumeIO.h"

#include <algorithm>
#include <cmath>

namespace innergs::bench {
namespace {

constexpr std::int64_t kEdge = 80;

/// Moves the slices of `axis` last.
Volume middleAlong(const Volume& volume, int axis) {
  const auto& n = volume.geometry.size;
  const int order[3] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, axis};
  Volume out;
  std::int64_t first[3];
  for (int a = 0; a < 3; ++a) {
    out.geometry.size[a] = std::min(kEdge, n[order[a]]);
    out.geometry.spacing[a] = volume.geometry.spacing[order[a]];
    first[a] = (n[order[a]] - out.geometry.size[a]) / 2;
  }
  const std::int64_t stride[3] = {1, n[0], n[0] * n[1]};
  for (std::int64_t k = 0; k < out.geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < out.geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < out.geometry.size[0]; ++i)
        out.voxels.push_back(
            volume.voxels[(first[0] + i) * stride[order[0]] + (first[1] + j) * stride[order[1]] +
                          (first[2] + k) * stride[order[2]]]);
  return out;
}

Volume blurred(const Volume& volume, int sigma) {
  if (sigma == 0) return volume;
  Volume out = volume;
  const std::int64_t slices = volume.geometry.size[2],
                     plane = volume.geometry.size[0] * volume.geometry.size[1];
  std::fill(out.voxels.begin(), out.voxels.end(), 0.f);
  const std::int64_t reach = 4 * sigma;
  double sum = 0;
  for (std::int64_t t = -reach; t <= reach; ++t)
    sum += std::exp(-0.5 * static_cast<double>(t * t) / (sigma * sigma));
  for (std::int64_t k = 0; k < slices; ++k)
    for (std::int64_t t = -reach; t <= reach; ++t) {
      const auto w = static_cast<float>(std::exp(-0.5 * static_cast<double>(t * t) / (sigma * sigma)) / sum);
      const std::int64_t from = std::clamp<std::int64_t>(k + t, 0, slices - 1) * plane;
      for (std::int64_t p = 0; p < plane; ++p)
        out.voxels[k * plane + p] += w * volume.voxels[from + p];
    }
  return out;
}

} // namespace

std::vector<SweepVolume> makeSweepVolumes(const std::filesystem::path& volume,
                                          const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const Volume whole = readVolume(volume);
  std::vector<SweepVolume> made;
  for (int axis = 0; axis < 3; ++axis) {
    const Volume middle = middleAlong(whole, axis);
    for (const int sigma : {0, 1, 2}) {
      const std::string name = "axis-" + std::to_string(axis) + "-blur-" + std::to_string(sigma);
      made.push_back({name, folder / (name + ".nii")});
      if (!std::filesystem::exists(made.back().path)) writeVolume(blurred(middle, sigma), made.back().path);
    }
  }
  return made;
}

} // namespace innergs::bench
