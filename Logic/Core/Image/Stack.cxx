#include "Core/Image/Stack.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/SliceOverlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

bool isRigid(const Affine3& pose) {
  const Mat3 gram = transpose(pose.linear) * pose.linear;
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(pose.offset[i])) return false;
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] - (i == j)) <= 1e-4)) return false;
  }
  return determinant(pose.linear) > 0;
}

} // namespace

void checkThickness(double thickness, const GridGeometry& geometry, const std::string& what, bool posed) {
  if (!std::isfinite(thickness) || thickness < 0)
    throw Error(ErrorCode::InvalidArgument,
                what + " has a slice thickness that is negative or not finite: give it in mm, or 0 for the "
                       "distance between slices.");
  const double distance = geometry.spacing[2];
  if (!posed && thickness > kMostOverlap * distance * (1 + 1e-6))
    throw Error(ErrorCode::InvalidArgument, what + " has a slice thickness of " + numberText(thickness) +
                                                " mm, and its slices lie " + numberText(distance) +
                                                " mm apart: give the thickness in mm, at most " +
                                                numberText(kMostOverlap * distance) + ".");
}

void checkStack(const Stack& stack) {
  const std::string what = stack.name.empty() ? "The stack" : stack.name;
  const auto fail = [&](ErrorCode code, const std::string& sentence) { throw Error(code, what + sentence); };
  checkGeometry(stack.image.geometry, what);
  const auto count = static_cast<std::size_t>(stack.image.geometry.voxelCount());
  const auto slices = static_cast<std::size_t>(stack.image.geometry.size[2]);
  if (stack.image.voxels.size() != count)
    fail(ErrorCode::InvalidArgument, " has " + std::to_string(stack.image.voxels.size()) +
                                         " voxels, but its size says " + std::to_string(count) + ".");
  if (!stack.observed.empty() && stack.observed.size() != count)
    fail(ErrorCode::InvalidArgument, " has a map of observed voxels that differs in size from its image.");
  if (!stack.poses.empty() && stack.poses.size() != slices)
    fail(ErrorCode::InvalidArgument, " has " + std::to_string(stack.poses.size()) + " slice poses for " +
                                         std::to_string(slices) + " slices: give one per slice or none.");
  if (!stack.times.empty() && stack.times.size() != slices)
    fail(ErrorCode::InvalidArgument, " has " + std::to_string(stack.times.size()) + " slice times for " +
                                         std::to_string(slices) + " slices: give one per slice or none.");
  checkThickness(stack.thickness, stack.image.geometry, what, !stack.poses.empty());
  const double pixel = std::min(stack.image.geometry.spacing[0], stack.image.geometry.spacing[1]);
  if (!(stack.pixelWidth >= 0 && stack.pixelWidth <= kMostOverlap * pixel))
    fail(ErrorCode::InvalidArgument, " has pixels of " + numberText(pixel) +
                                         " mm that average over a width of " + numberText(stack.pixelWidth) +
                                         " mm: give at least 0 and at most " +
                                         numberText(kMostOverlap * pixel) + " mm.");
  for (const Affine3& pose : stack.poses)
    if (!isRigid(pose))
      fail(ErrorCode::Geometry, " has a slice pose that is not rigid (a rotation and a shift): correct it.");
  for (double time : stack.times)
    if (!std::isfinite(time)) fail(ErrorCode::InvalidArgument, " has a slice time that is not finite.");
  if (std::none_of(stack.image.voxels.begin(), stack.image.voxels.end(),
                   [](float v) { return std::isfinite(v); }))
    fail(ErrorCode::NoData, " has no finite voxel: there is nothing to fit.");
  if (!stack.observed.empty()) {
    bool any = false;
    for (std::size_t i = 0; i < count && !any; ++i)
      any = stack.observed[i] && std::isfinite(stack.image.voxels[i]);
    if (!any) fail(ErrorCode::NoData, " has no observed finite voxel: check the mask.");
  }
}

ValueRange observedRange(std::span<const Stack> stacks) {
  ValueRange range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
  for (const Stack& stack : stacks)
    for (std::size_t v = 0; v < stack.image.voxels.size(); ++v) {
      if (!isKnown(stack, v)) continue;
      range.low = std::min(range.low, stack.image.voxels[v]);
      range.high = std::max(range.high, stack.image.voxels[v]);
    }
  if (range.low > range.high)
    throw Error(ErrorCode::NoData, "The images have no finite observed voxel: check the mask.");
  return range;
}

bool isKnown(const Stack& stack, std::size_t voxel) {
  return std::isfinite(stack.image.voxels[voxel]) && (stack.observed.empty() || stack.observed[voxel]);
}

Volume observedImage(const Stack& stack) {
  Volume image = stack.image;
  for (std::size_t v = 0; v < stack.observed.size(); ++v)
    if (!stack.observed[v]) image.voxels[v] = std::numeric_limits<float>::quiet_NaN();
  return image;
}

Stack withSliceAxis(const Stack& stack, int axis) {
  if (axis == 2) return stack;
  Stack result;
  result.image = withSliceAxis(stack.image, axis);
  result.profile = stack.profile;
  if (!stack.observed.empty())
    result.observed = withSliceAxis(Mask{stack.image.geometry, stack.observed}, axis).voxels;
  result.isRegion = stack.isRegion;
  result.name = stack.name;
  result.remarks = stack.remarks;
  return result;
}

} // namespace innergs
