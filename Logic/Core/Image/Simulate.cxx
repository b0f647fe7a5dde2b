#include "Core/Image/Simulate.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <numbers>
#include <random>

namespace innergs {
namespace {

void checkInput(const Volume& volume, int axis, int step, const char* what) {
  checkGeometry(volume.geometry, "The volume");
  if (axis < 0 || axis > 2) throw Error(ErrorCode::InvalidArgument, "A slice axis must be 0, 1 or 2.");
  if (volume.voxels.size() != static_cast<std::size_t>(volume.geometry.voxelCount()))
    throw Error(ErrorCode::InvalidArgument, "The volume's voxels do not match its size.");
  if (step < 1 || step > volume.geometry.size[axis])
    throw Error(ErrorCode::InvalidArgument,
                std::string(what) + " must lie between 1 and the number of slices (" +
                    std::to_string(volume.geometry.size[axis]) + "), it is " + std::to_string(step) + ".");
}

} // namespace

// std::normal_distribution gives other numbers with every standard library.
void addNoise(std::vector<float>& voxels, double sigma, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return (double(engine() >> 11) + 0.5) * 0x1p-53; };
  for (std::size_t i = 0; i < voxels.size(); i += 2) {
    const double radius = sigma * std::sqrt(-2 * std::log(uniform()));
    const double angle = 2 * std::numbers::pi * uniform();
    voxels[i] += static_cast<float>(radius * std::cos(angle));
    if (i + 1 < voxels.size()) voxels[i + 1] += static_cast<float>(radius * std::sin(angle));
  }
}

Stack simulateThickStack(const Volume& volume, int axis, int thickness, double noise, std::uint64_t seed) {
  checkInput(volume, axis, thickness, "The thickness in slices");
  if (!std::isfinite(noise) || noise < 0)
    throw Error(ErrorCode::InvalidArgument, "The noise must be finite and at least zero.");
  Volume thin = withSliceAxis(volume, axis);
  const auto plane = static_cast<std::size_t>(thin.geometry.size[0] * thin.geometry.size[1]);
  const std::int64_t slices = thin.geometry.size[2] / thickness;

  Stack stack;
  stack.profile = thickness == 1 ? SliceProfile::Point : SliceProfile::Box;
  stack.thickness = thickness * thin.geometry.spacing[2];
  stack.image.geometry = thin.geometry;
  stack.image.geometry.size[2] = slices;
  stack.image.geometry.spacing[2] = stack.thickness;
  stack.image.geometry.origin = thin.geometry.indexToWorld()({0, 0, 0.5 * (thickness - 1)});
  stack.image.voxels.resize(plane * static_cast<std::size_t>(slices));
  std::vector<double> sum(plane);
  for (std::int64_t slice = 0; slice < slices; ++slice) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (int t = 0; t < thickness; ++t) {
      const float* in = thin.voxels.data() + plane * static_cast<std::size_t>(slice * thickness + t);
      for (std::size_t p = 0; p < plane; ++p)
        sum[p] += in[p];
    }
    float* out = stack.image.voxels.data() + plane * static_cast<std::size_t>(slice);
    for (std::size_t p = 0; p < plane; ++p)
      out[p] = static_cast<float>(sum[p] / thickness);
  }
  if (noise > 0) addNoise(stack.image.voxels, noise, seed);
  return stack;
}

Stack keepEvery(const Volume& volume, int axis, int k) {
  checkInput(volume, axis, k, "The step between kept slices");
  Volume thin = withSliceAxis(volume, axis);
  const auto plane = static_cast<std::size_t>(thin.geometry.size[0] * thin.geometry.size[1]);
  const std::int64_t slices = (thin.geometry.size[2] + k - 1) / k;

  Stack stack;
  stack.profile = SliceProfile::Point;
  stack.thickness = thin.geometry.spacing[2];
  stack.image.geometry = thin.geometry;
  stack.image.geometry.size[2] = slices;
  stack.image.geometry.spacing[2] *= k;
  stack.image.voxels.resize(plane * static_cast<std::size_t>(slices));
  for (std::int64_t slice = 0; slice < slices; ++slice)
    std::copy_n(thin.voxels.begin() + static_cast<std::ptrdiff_t>(plane) * slice * k, plane,
                stack.image.voxels.begin() + static_cast<std::ptrdiff_t>(plane) * slice);
  return stack;
}

} // namespace innergs
