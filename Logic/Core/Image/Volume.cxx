#include "Core/Image/Volume.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"

#include <algorithm>

namespace innergs {

float sampleLinear(const Volume& volume, const Vec3& index) {
  std::int64_t low[3], high[3];
  double fraction[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double last = double(volume.geometry.size[axis] - 1);
    const double x = index[axis] > 0 ? std::min(index[axis], last) : 0.0; // NaN → 0
    low[axis] = static_cast<std::int64_t>(x);
    high[axis] = std::min<std::int64_t>(low[axis] + 1, volume.geometry.size[axis] - 1);
    fraction[axis] = x - double(low[axis]);
  }
  const std::int64_t width = volume.geometry.size[0], height = volume.geometry.size[1];
  const auto row = [&](std::int64_t j, std::int64_t k) {
    const float* p = volume.voxels.data() + width * (j + height * k);
    return fraction[0] == 0 ? double(p[low[0]])
                            : p[low[0]] + fraction[0] * (double(p[high[0]]) - double(p[low[0]]));
  };
  const auto plane = [&](std::int64_t k) {
    const double a = row(low[1], k);
    return fraction[1] == 0 ? a : a + fraction[1] * (row(high[1], k) - a);
  };
  const double a = plane(low[2]);
  return static_cast<float>(fraction[2] == 0 ? a : a + fraction[2] * (plane(high[2]) - a));
}

bool sampleInside(const GridGeometry& geometry, const float* voxels, const Vec3& index, float& value) {
  constexpr double tolerance = 0.5 + 1e-6; // rounding errors of the index maps
  std::size_t step[3], stride = 1;
  float f[3];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = geometry.size[a];
    if (!(index[a] >= -tolerance && index[a] <= static_cast<double>(n - 1) + tolerance)) return false;
    const double x = std::clamp(index[a], 0.0, static_cast<double>(n - 1));
    const std::int64_t low = std::min(static_cast<std::int64_t>(x), std::max<std::int64_t>(0, n - 2));
    voxels += static_cast<std::size_t>(low) * stride;
    f[a] = static_cast<float>(x - static_cast<double>(low));
    step[a] = n > 1 ? stride : 0;
    stride *= static_cast<std::size_t>(n);
  }
  const auto line = [&](const float* p) { return p[0] + f[0] * (p[step[0]] - p[0]); };
  const auto plane = [&](const float* p) { return line(p) + f[1] * (line(p + step[1]) - line(p)); };
  value = plane(voxels) + f[2] * (plane(voxels + step[2]) - plane(voxels));
  return true;
}

std::array<int, 3> axesWithSliceAxis(int axis) {
  if (axis < 0 || axis > 2) throw Error(ErrorCode::InvalidArgument, "A slice axis must be 0, 1 or 2.");
  return axis == 0 ? std::array{1, 2, 0} : axis == 1 ? std::array{0, 2, 1} : std::array{0, 1, 2};
}

namespace {

template <class Image>
Image sliceAxisMoved(const Image& image, int axis) {
  const std::array<int, 3> from = axesWithSliceAxis(axis);
  if (axis == 2) return image;
  const GridGeometry& g = image.geometry;
  const std::array<std::int64_t, 3> stride{1, g.size[0], g.size[0] * g.size[1]};
  Image result;
  result.geometry = withSliceAxis(g, axis);
  const auto& n = result.geometry.size;
  result.voxels.resize(image.voxels.size());
  auto* out = result.voxels.data();
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const auto* in = image.voxels.data() + j * stride[from[1]] + k * stride[from[2]];
      for (std::int64_t i = 0; i < n[0]; ++i)
        *out++ = in[i * stride[from[0]]];
    }
  return result;
}

} // namespace

GridGeometry withSliceAxis(const GridGeometry& g, int axis) {
  const std::array<int, 3> from = axesWithSliceAxis(axis);
  GridGeometry result;
  result.origin = g.origin;
  for (int a = 0; a < 3; ++a) {
    result.size[a] = g.size[from[a]];
    result.spacing[a] = g.spacing[from[a]];
    for (int r = 0; r < 3; ++r)
      result.direction[r][a] = g.direction[r][from[a]];
  }
  return result;
}

Volume withSliceAxis(const Volume& volume, int axis) {
  return sliceAxisMoved(volume, axis);
}

Mask withSliceAxis(const Mask& mask, int axis) {
  return sliceAxisMoved(mask, axis);
}

std::vector<std::uint8_t> resampleMask(const Mask& mask, const GridGeometry& geometry,
                                       const std::stop_token& stop) {
  std::vector<std::uint8_t> result(static_cast<std::size_t>(geometry.voxelCount()), 0);
  const Affine3 toMask = inverse(mask.geometry.indexToWorld()) * geometry.indexToWorld();
  const auto& n = mask.geometry.size;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < geometry.size[2]; ++k) {
    throwIfStopped(stop);
    for (std::int64_t j = 0; j < geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < geometry.size[0]; ++i, ++at) {
        const Vec3 x = toMask({double(i), double(j), double(k)});
        std::int64_t nearest[3];
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
          inside = inside && x[axis] >= -0.5 && x[axis] <= double(n[axis]) - 0.5;
          if (inside)
            nearest[axis] = std::min(static_cast<std::int64_t>(std::floor(x[axis] + 0.5)), n[axis] - 1);
        }
        if (inside)
          result[at] =
              mask.voxels[static_cast<std::size_t>(nearest[0] + n[0] * (nearest[1] + n[1] * nearest[2]))] !=
              0;
      }
  }
  return result;
}

} // namespace innergs
