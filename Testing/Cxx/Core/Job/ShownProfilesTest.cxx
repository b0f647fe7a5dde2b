#include "Core/Job/ShownProfiles.h"

#include "Core/Acquisition/ProjectToStack.h"
#include "JobInputs.h"
#include "Prediction/SpherePhantom.h"

namespace innergs::testing {
namespace {

/// Slices 3 mm apart that average `thickness` mm, though none is stated.
Stack slicesOf(double thickness) {
  ThreadPool pool(2);
  const Volume truth = spherePhantom(96, 128, 2);
  Stack stack = keepEvery(truth, 2, 3);
  stack.profile = SliceProfile::Box;
  stack.thickness = thickness;
  stack.image.voxels = projectToStack(truth, stack, pool);
  addNoise(stack.image.voxels, 2, 5);
  stack.thickness = 0;
  return stack;
}

std::string sentenceOf(const std::vector<Stack>& stacks) {
  ThreadPool pool(2);
  const ShownProfiles shown = shownProfiles(stacks, pool);
  EXPECT_EQ(shown.scans.size(), stacks.size());
  return shown.sentence;
}

bool says(const std::string& sentence, const std::string& part) {
  return sentence.find(part) != std::string::npos;
}

TEST(ShownProfiles, NameSlicesThatLookThickerThanStated) {
  Stack stack = slicesOf(6);
  const std::string assumed = sentenceOf({stack});
  EXPECT_TRUE(says(assumed, " mm thick, 3 mm apart, but were fitted as 3 mm thick")) << assumed;
  stack.thickness = 6;
  const std::string stated = sentenceOf({stack});
  EXPECT_TRUE(says(stated, " mm thick, 3 mm apart.")) << stated;
}

TEST(ShownProfiles, NameSlicesThatLookThinnerThanStated) {
  Stack stack = slicesOf(1);
  const std::string thin = sentenceOf({stack});
  EXPECT_TRUE(says(thin, "no thicker than their distance of 3 mm.")) << thin;
  stack.thickness = 6;
  const std::string stated = sentenceOf({stack});
  EXPECT_TRUE(says(stated, "were fitted as 6 mm thick")) << stated;
}

TEST(ShownProfiles, AreSaidOfEachScanThatShowsThem) {
  Stack named = slicesOf(6), constant = slicesOf(6), posed = slicesOf(6);
  named.name = "axial";
  std::fill(constant.image.voxels.begin(), constant.image.voxels.end(), 7.f);
  posed.poses.resize(static_cast<std::size_t>(posed.image.geometry.size[2]));
  const std::string sentence = sentenceOf({constant, named, posed});
  EXPECT_EQ(sentence.substr(0, 24), "The slices of axial look") << sentence;
  EXPECT_FALSE(says(sentence, "Stack")) << sentence;
}

TEST(ShownProfiles, BelongToAResult) {
  const auto result = reconstruct(inputOf({slicesOf(6)}), quickSettings(2));
  ASSERT_EQ(result.profiles.scans.size(), 1u);
  EXPECT_NEAR(result.profiles.scans[0].thickness, 6, 0.9);
  EXPECT_EQ(result.profiles.sentence, sentenceOf({slicesOf(6)}));
}

} // namespace
} // namespace innergs::testing
