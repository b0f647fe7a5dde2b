#include "Core/Prediction/ProfileEstimate.h"

#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Image/Simulate.h"
#include "SpherePhantom.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

using testing::spherePhantom;

Stack slicesOf(const Volume& truth, SliceProfile profile, double thickness, int gap, double noise) {
  ThreadPool pool(2);
  Stack stack = keepEvery(truth, 2, gap);
  stack.profile = profile;
  stack.thickness = thickness;
  stack.image.voxels = projectToStack(truth, stack, pool);
  addNoise(stack.image.voxels, noise, 5);
  stack.thickness = 0; // must be estimated
  return stack;
}

ProfileEstimate estimate(const Stack& stack) {
  ThreadPool pool(2);
  return estimateProfile(stack, pool);
}

TEST(ProfileEstimate, FindsTheWidthOfSimulatedProfiles) {
  constexpr int gap = 4;
  const Volume truth = spherePhantom(96, 128, 2);
  for (const SliceProfile profile : {SliceProfile::Box, SliceProfile::Gaussian})
    for (const double share : {0.5, 1.0, 1.5, 2.0}) {
      const ProfileEstimate e = estimate(slicesOf(truth, profile, share * gap, gap, 2));
      ASSERT_TRUE(e.known) << e.sentence;
      // T sub-planes of point samples, a voxel apart, vary like a box of √(T² − 1).
      const double thickness = share * gap,
                   width = profile == SliceProfile::Box ? std::sqrt(thickness * thickness - 1) : thickness;
      EXPECT_NEAR(e.thickness, width, 0.15 * width)
          << (profile == SliceProfile::Box ? "box " : "Gaussian ") << share;
      EXPECT_EQ(e.spacing, gap);
      EXPECT_GT(e.confidence, 0.4);
    }
}

TEST(ProfileEstimate, SaysItInASentence) {
  const ProfileEstimate e = estimate(slicesOf(spherePhantom(96, 128, 2), SliceProfile::Box, 6, 3, 2));
  ASSERT_TRUE(e.known);
  EXPECT_EQ(e.sentence.substr(0, 12), "Slices look ");
  EXPECT_NE(e.sentence.find(" mm thick, 3 mm apart."), std::string::npos) << e.sentence;
}

TEST(ProfileEstimate, SaysWhatCannotBeTold) {
  const Stack stack = slicesOf(spherePhantom(64, 60), SliceProfile::Box, 3, 3, 1);
  const auto sentence = [](const Stack& s) {
    const ProfileEstimate e = estimate(s);
    EXPECT_FALSE(e.known);
    return e.sentence;
  };
  Stack few = stack;
  few.image.geometry.size[2] = 4;
  few.image.voxels.resize(4 * 64 * 64);
  EXPECT_NE(sentence(few).find("too few"), std::string::npos);
  Stack constant = stack;
  std::fill(constant.image.voxels.begin(), constant.image.voxels.end(), 1.f);
  EXPECT_NE(sentence(constant).find("constant"), std::string::npos);
  Stack labels = stack;
  for (float& v : labels.image.voxels)
    v = v > 90;
  EXPECT_NE(sentence(labels).find("labels"), std::string::npos);
  Stack noise = stack;
  std::fill(noise.image.voxels.begin(), noise.image.voxels.end(), 100.f);
  addNoise(noise.image.voxels, 20, 3);
  EXPECT_NE(sentence(noise).find("noisy"), std::string::npos);
}

TEST(ProfileEstimate, HeldOutVoxelsChangeNothing) {
  Stack stack = slicesOf(spherePhantom(64, 60), SliceProfile::Box, 3, 3, 1);
  stack.observed.assign(stack.image.voxels.size(), 1);
  for (std::size_t p = 0; p < 64 * 64; ++p)
    stack.observed[5 * 64 * 64 + p] = 0;
  Stack other = stack;
  for (std::size_t p = 0; p < 64 * 64; ++p)
    other.image.voxels[5 * 64 * 64 + p] = 1e4f * static_cast<float>(p % 7);
  const ProfileEstimate a = estimate(stack), b = estimate(other);
  EXPECT_TRUE(a.known);
  EXPECT_EQ(a.thickness, b.thickness);
}

} // namespace
} // namespace innergs
