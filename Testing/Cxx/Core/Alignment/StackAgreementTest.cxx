#include "Core/Alignment/StackAgreement.h"

#include "../Prediction/SpherePhantom.h"
#include "Core/Image/Simulate.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr std::int64_t kWide = 64;

/// Scans of 4 mm slices at right angles, each of its own body.
std::vector<Stack> scansOf(const std::vector<std::uint64_t>& bodies) {
  std::vector<Stack> stacks;
  for (std::size_t s = 0; s < bodies.size(); ++s)
    stacks.push_back(simulateThickStack(testing::spherePhantom(kWide, kWide, bodies[s]),
                                        2 - static_cast<int>(s), 4, 1.0, s + 1));
  return stacks;
}

TEST(StackAgreement, OfStillScansIsHighAndSaidInDecibels) {
  ThreadPool pool(2);
  const auto found = compareStacks(scansOf({5, 5, 5}), pool);
  for (const StackAgreement& a : found) {
    EXPECT_TRUE(a.fits);
    EXPECT_GT(a.correlation, 0.95);
    EXPECT_NEAR(a.ratio, 1, 0.02);
    EXPECT_EQ(misfitSentence(a, "Scan"), "");
  }
  const std::string said = agreementSentence(found);
  EXPECT_EQ(said.find("The scans agree: PSNR between them "), 0u) << said;
  EXPECT_EQ(said.find("result"), std::string::npos) << "nothing was measured after a fit";
}

TEST(StackAgreement, NamesTheStrangerWhereverItStands) {
  ThreadPool pool(2);
  for (std::size_t stranger = 0; stranger < 3; ++stranger) {
    std::vector<std::uint64_t> bodies{5, 5, 5};
    bodies[stranger] = 11;
    const auto found = compareStacks(scansOf(bodies), pool);
    for (std::size_t s = 0; s < 3; ++s)
      EXPECT_EQ(found[s].fits, s != stranger) << s << ": " << found[s].correlation;
    EXPECT_EQ(misfitSentence(found[stranger], "cor").find("cor does not fit the other scans"), 0u);
    EXPECT_EQ(agreementSentence(found).find("Not all scans agree"), 0u);
  }
}

TEST(StackAgreement, FallsWhereAScanMovedOrIsBrighter) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scansOf({5, 5});
  const double still = compareStacks(stacks, pool)[1].psnr;
  for (float& v : stacks[1].image.voxels)
    v *= 1.2f;
  const auto brighter = compareStacks(stacks, pool);
  EXPECT_NEAR(brighter[1].ratio, 1 / 1.2, 0.02);
  EXPECT_LT(brighter[1].psnr, still - 5);
  EXPECT_EQ(agreementSentence(brighter).find("The scans agree except in brightness"), 0u);
  stacks = scansOf({5, 5});
  stacks[1].image.geometry.origin[1] += 3;
  EXPECT_LT(compareStacks(stacks, pool)[1].psnr, still - 5);
}

TEST(StackAgreement, OfScansWithPosesIsNotKnown) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scansOf({5, 5});
  stacks[1].poses.resize(static_cast<std::size_t>(stacks[1].image.geometry.size[2]));
  const auto found = compareStacks(stacks, pool);
  EXPECT_TRUE(found[0].fits && found[1].fits);
  EXPECT_EQ(agreementSentence(found).find("Whether the scans agree is not known"), 0u);
  EXPECT_EQ(agreementSentence(std::span(found).first(1)), "");
}

} // namespace
} // namespace innergs
