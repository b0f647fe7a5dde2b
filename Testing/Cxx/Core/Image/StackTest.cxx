#include "Core/Image/Stack.h"

#include "TestVolumes.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

Stack validStack() {
  Stack stack;
  stack.image = randomVolume(grid(4, 5, 6, {1, 1, 3}), 0, 100);
  stack.thickness = 3;
  stack.name = "T2.nii.gz";
  return stack;
}

ErrorCode codeOf(const Stack& stack) {
  const Error error = test::errorOf([&] { checkStack(stack); });
  EXPECT_TRUE(test::contains(error, "T2.nii.gz")) << error.what();
  return error.code();
}

} // namespace

TEST(Stack, AcceptsPosesTimesAndPartlyObserved) {
  Stack stack = validStack();
  stack.poses.assign(6, Affine3{obliqueDirection(0.1), {1, 2, 3}});
  stack.times.assign(6, 0.5);
  stack.observed.assign(120, 0);
  stack.observed[7] = 1;
  stack.image.voxels[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NO_THROW(checkStack(stack));
}

TEST(Stack, RefusesWhatDoesNotFitTogether) {
  Stack stack = validStack();
  stack.image.voxels.pop_back();
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
  stack = validStack();
  stack.observed.assign(119, 1);
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
  stack = validStack();
  stack.poses.resize(5);
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
  stack = validStack();
  stack.times.resize(7);
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
  stack = validStack();
  stack.thickness = -1;
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
}

// 400 mm instead of 4 mm by mistake would blur everything; overlapping slices are common.
TEST(Stack, RefusesAThicknessThatNoSliceHas) {
  const auto refused = [](double thickness, double distance, std::int64_t slices) {
    try {
      checkThickness(thickness, grid(4, 5, slices, {1, 1, distance}), "T2.nii.gz");
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      return true;
    }
  };
  for (const double good : {0.0, 0.1, 4.0, 8.0, 64.0})
    EXPECT_FALSE(refused(good, 4, 40)) << good;
  EXPECT_FALSE(refused(5, 0.625, 300));
  for (const double bad : {-4.0, 64.1, 400.0, double(INFINITY), double(NAN)})
    EXPECT_TRUE(refused(bad, 4, 40)) << bad;
  EXPECT_FALSE(refused(13, 4, 2)); // a region may contain few slices of a scan
  Stack stack = validStack();
  stack.thickness = 300;
  EXPECT_EQ(codeOf(stack), ErrorCode::InvalidArgument);
}

TEST(Stack, RefusesPosesThatAreNotRigid) {
  Stack stack = validStack();
  stack.poses.assign(6, Affine3{});
  stack.poses[2].linear = diagonal({1, 1, 1.1});
  EXPECT_EQ(codeOf(stack), ErrorCode::Geometry);
  stack.poses[2].linear = diagonal({1, 1, -1});
  EXPECT_EQ(codeOf(stack), ErrorCode::Geometry);
}

TEST(Stack, RefusesNothingToFit) {
  Stack stack = validStack();
  stack.observed.assign(120, 0);
  EXPECT_EQ(codeOf(stack), ErrorCode::NoData);
  stack.observed[5] = 1;
  stack.image.voxels[5] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(codeOf(stack), ErrorCode::NoData);
  stack = validStack();
  stack.image.voxels.assign(120, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(codeOf(stack), ErrorCode::NoData);
}

TEST(Stack, WithSliceAxisTakesWhatIsObservedAlong) {
  Stack stack = validStack();
  stack.profile = SliceProfile::Point;
  for (float v : stack.image.voxels) // the observed value identifies the voxel
    stack.observed.push_back(v > 40);
  for (int axis = 0; axis < 3; ++axis) {
    const Stack moved = withSliceAxis(stack, axis);
    EXPECT_NO_THROW(checkStack(moved));
    EXPECT_EQ(moved.image.geometry, withSliceAxis(stack.image.geometry, axis));
    EXPECT_EQ(moved.image.voxels, withSliceAxis(stack.image, axis).voxels);
    ASSERT_EQ(moved.observed.size(), stack.observed.size());
    for (std::size_t v = 0; v < moved.observed.size(); ++v)
      EXPECT_EQ(moved.observed[v], moved.image.voxels[v] > 40);
    EXPECT_EQ(moved.thickness, axis == 2 ? 3 : 0) << "the slice spacing there";
    EXPECT_EQ(moved.profile, stack.profile);
  }
  EXPECT_THROW(withSliceAxis(stack, 3), Error);
}

TEST(Stack, ObservedRangeIsThatOfTheFiniteObservedVoxels) {
  Stack a = validStack(), b = validStack();
  a.image.voxels.assign(120, 10.f);
  a.image.voxels[3] = -7; // one voxel of 240 counts
  a.image.voxels[4] = -std::numeric_limits<float>::infinity();
  b.image.voxels.assign(120, 20.f);
  b.image.voxels[0] = 1e6f;
  b.image.voxels[1] = 33;
  b.observed.assign(120, 1);
  b.observed[0] = 0;
  const std::vector<Stack> stacks{a, b};
  const ValueRange range = observedRange(stacks);
  EXPECT_EQ(range.low, -7);
  EXPECT_EQ(range.high, 33);
  b.observed.assign(120, 0);
  EXPECT_THROW(observedRange({&b, 1}), Error);
}
