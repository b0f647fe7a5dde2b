#include "Core/Alignment/StackAlignment.h"

#include "Core/Image/Simulate.h"
#include "HeadPhantom.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace innergs {
namespace {

Volume head() {
  return testing::headPhantom(80);
}

/// Three orthogonal scans with 4 mm slices.
std::vector<Stack> scans(const Volume& truth) {
  std::vector<Stack> stacks;
  for (const int axis : {2, 1, 0})
    stacks.push_back(simulateThickStack(truth, axis, 4, 1.0, static_cast<std::uint64_t>(axis) + 1));
  return stacks;
}

Affine3 turned(double degrees, const Vec3& shift, const Vec3& centre) {
  const double a = degrees * std::numbers::pi / 180;
  Mat3 r;
  r[0] = {std::cos(a), -std::sin(a), 0};
  r[1] = {std::sin(a), std::cos(a), 0};
  return {r, centre + shift - r * centre};
}

/// As if the patient had moved before the scan: its voxels are not where its header says.
void displace(Stack& stack, const Affine3& motion) {
  GridGeometry& g = stack.image.geometry;
  g.origin = motion(g.origin);
  g.direction = motion.linear * g.direction;
}

TEST(StackAlignment, LeavesStillScansAlone) {
  ThreadPool pool(2);
  const auto found = alignStacks(scans(head()), pool);
  for (const StackAlignment& a : found) {
    EXPECT_TRUE(a.fits);
    EXPECT_EQ(a.displacement, 0);
    EXPECT_EQ(a.toOthers, Affine3{});
    EXPECT_EQ(a.gain, 1);
    EXPECT_EQ(alignmentSentence(a, "Scan"), "");
  }
  EXPECT_GT(found[1].correlation, 0.95);
}

TEST(StackAlignment, FindsMotionAndGainOfScans) {
  ThreadPool pool(2);
  const Volume truth = head();
  std::vector<Stack> stacks = scans(truth);
  const Affine3 motions[] = {{}, turned(4, {2, -1.5, 1}, {40, 40, 40}), turned(-2, {0, 3, -1}, {40, 40, 40})};
  for (int s = 1; s < 3; ++s)
    displace(stacks[s], motions[s]);
  for (float& v : stacks[2].image.voxels)
    v *= 1.3f;
  const auto found = alignStacks(stacks, pool);
  applyAlignment(found, stacks);
  const std::vector<Stack> still = scans(truth);
  for (int s = 1; s < 3; ++s) {
    EXPECT_TRUE(found[s].fits) << s;
    EXPECT_GT(found[s].psnrAfter, found[s].psnrBefore + 5);
    for (const Vec3& index : {Vec3{20, 20, 5}, Vec3{60, 20, 15}, Vec3{20, 60, 15}, Vec3{60, 60, 5}})
      EXPECT_LT(norm(stacks[s].image.geometry.indexToWorld()(index) -
                     still[s].image.geometry.indexToWorld()(index)),
                0.25)
          << s;
  }
  EXPECT_NEAR(found[1].gain, 1, 0.01);
  EXPECT_NEAR(found[2].gain, 1 / 1.3, 0.01);
  EXPECT_NEAR(found[1].angle, 4, 0.15);
  EXPECT_NE(alignmentSentence(found[1], "Scan 2").find("turned by "), std::string::npos)
      << alignmentSentence(found[1], "Scan 2");
  EXPECT_NE(alignmentSentence(found[2], "Scan 3").find("multiplied by 0.7"), std::string::npos);
}

TEST(StackAlignment, SaysWhichScanDoesNotFit) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans(head());
  for (float& v : stacks[1].image.voxels)
    if (v > 20) v = 220 - v; // another contrast
  const auto found = alignStacks(stacks, pool);
  EXPECT_FALSE(found[1].fits);
  EXPECT_EQ(found[1].toOthers, Affine3{});
  EXPECT_EQ(found[1].gain, 1);
  EXPECT_NE(alignmentSentence(found[1], "Scan 2").find("does not fit"), std::string::npos);
}

TEST(StackAlignment, SaysThatNoiseDoesNotFit) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans(head());
  std::mt19937 random(5);
  for (float& v : stacks[1].image.voxels)
    v = static_cast<float>(random() % 200);
  const auto found = alignStacks(stacks, pool);
  EXPECT_FALSE(found[1].fits);
  EXPECT_EQ(found[1].toOthers, Affine3{});
  EXPECT_EQ(found[1].gain, 1);
  EXPECT_NE(alignmentSentence(found[1], "Scan 2"), "");
  EXPECT_TRUE(found[2].fits);
}

TEST(StackAlignment, SaysThatTheFirstScanFitsNone) {
  ThreadPool pool(2);
  const Volume truth = head();
  std::vector<Stack> stacks = scans(truth);
  std::mt19937 random(5);
  for (float& v : stacks[0].image.voxels)
    v = static_cast<float>(random() % 200);
  displace(stacks[2], turned(0, {2, 0, -1}, {}));
  const auto found = alignStacks(stacks, pool);
  EXPECT_FALSE(found[0].fits);
  EXPECT_EQ(found[0].toOthers, Affine3{});
  EXPECT_NE(alignmentSentence(found[0], "Scan 1").find("does not fit"), std::string::npos);
  EXPECT_TRUE(found[1].fits);
  EXPECT_TRUE(found[2].fits);
  EXPECT_LT(norm(found[2].toOthers({40, 40, 40}) - Vec3{38, 40, 41}), 0.25);
  stacks[1].image.voxels = stacks[0].image.voxels; // two of noise: no telling which is wrong
  const auto lost = alignStacks(stacks, pool);
  EXPECT_TRUE(lost[0].fits);
  EXPECT_FALSE(lost[1].fits);
  EXPECT_FALSE(lost[2].fits);
}

TEST(StackAlignment, StatesNoFigureThatIsUnknown) {
  StackAlignment found;
  found.displacement = 12;
  found.psnrBefore = std::nan("");
  found.psnrAfter = 25;
  const std::string said = alignmentSentence(found, "Scan 2");
  EXPECT_NE(said.find("25.0 dB"), std::string::npos) << said;
  EXPECT_EQ(said.find("nan"), std::string::npos) << said;
}

TEST(StackAlignment, NeverLooksAtUnobservedVoxels) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans(head());
  displace(stacks[1], turned(0, {1, 0, 0}, {}));
  Stack& stack = stacks[1];
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  testing::holdOut(stack, {7});
  const auto before = alignStacks(stacks, pool);
  for (std::int64_t v = 7 * plane; v < 8 * plane; ++v)
    stack.image.voxels[v] = v % 2 ? 1e6f : std::nanf("");
  const auto after = alignStacks(stacks, pool);
  EXPECT_EQ(before[1].toOthers, after[1].toOthers);
  EXPECT_EQ(before[1].gain, after[1].gain);
  EXPECT_GT(after[1].displacement, 0.8);
}

TEST(StackAlignment, IsTheSameByAnyNumberOfThreads) {
  std::vector<Stack> stacks = scans(head());
  displace(stacks[2], turned(3, {1, 1, -2}, {40, 40, 40}));
  std::vector<std::vector<StackAlignment>> found;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    found.push_back(alignStacks(stacks, pool));
  }
  EXPECT_EQ(found[0][2].toOthers, found[1][2].toOthers);
  EXPECT_EQ(found[0][2].psnrAfter, found[1][2].psnrAfter);
}

TEST(StackAlignment, LeavesScansThatShareTooLittle) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans(head());
  stacks.resize(2);
  displace(stacks[1], turned(0, {0, 0, 300}, {}));
  const auto found = alignStacks(stacks, pool);
  EXPECT_TRUE(std::isnan(found[1].correlation));
  EXPECT_EQ(found[1].toOthers, Affine3{});
  EXPECT_EQ(alignmentSentence(found[1], "Scan 2"), "");
}

TEST(StackAlignment, AStrangerChangesNothingOfTheOthers) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans(testing::spherePhantom(80, 80, 5));
  stacks[2] = simulateThickStack(testing::spherePhantom(80, 80, 9), 0, 4, 1.0, 3);
  for (float& v : stacks[2].image.voxels)
    v *= 2;
  const auto found = alignStacks(stacks, pool);
  EXPECT_FALSE(found[2].fits);
  EXPECT_TRUE(found[1].fits);
  EXPECT_EQ(found[1].gain, 1);
  EXPECT_EQ(found[1].toOthers, Affine3{});
}

/// How far an alignment leaves a displaced scan from where it was, mm.
double distanceLeft(const StackAlignment& found, const Affine3& motion) {
  double worst = 0;
  for (const Vec3& x : {Vec3{20, 20, 20}, Vec3{60, 20, 40}, Vec3{40, 60, 60}})
    worst = std::max(worst, norm(found.toOthers(motion(x)) - x));
  return worst;
}

/// Balls in an ellipsoid, in air.
Volume longHead() {
  Volume volume = testing::spherePhantom(80, 80, 5);
  for (std::int64_t v = 0; v < 80 * 80 * 80; ++v) {
    const double x = static_cast<double>(v % 80 - 40) / 27, y = static_cast<double>(v / 80 % 80 - 40) / 37,
                 z = static_cast<double>(v / 6400 - 40) / 31;
    if (x * x + y * y + z * z > 1) volume.voxels[static_cast<std::size_t>(v)] = 0;
  }
  return volume;
}

TEST(StackAlignment, FindsScansThatLieFarApart) {
  ThreadPool pool(2);
  for (const double angle : {-50.0, 40.0}) {
    std::vector<Stack> stacks = scans(longHead());
    const Affine3 motion = turned(angle, {14, -12, 10}, {40, 40, 40});
    displace(stacks[1], motion);
    displace(stacks[2], motion);
    const auto found = alignStacks(stacks, pool);
    for (int s = 1; s < 3; ++s) {
      EXPECT_TRUE(found[s].fits) << angle;
      EXPECT_LT(distanceLeft(found[s], motion), 0.4) << angle;
    }
  }
}

/// Balls, and others beyond a plane: a part of the body moved otherwise.
Volume changedBalls(std::int64_t from) {
  Volume truth = testing::spherePhantom(80, 80, 5);
  const Volume other = testing::spherePhantom(80, 80, 9);
  for (std::size_t v = 0; v < truth.voxels.size(); ++v)
    if (static_cast<std::int64_t>(v) % 80 >= from) truth.voxels[v] = other.voxels[v];
  return truth;
}

TEST(StackAlignment, FindsScansThatAreAlikeInPart) {
  ThreadPool pool(2);
  const Affine3 motion = turned(6, {5, -4, 3}, {40, 40, 40});
  const auto align = [&](std::int64_t from) {
    std::vector<Stack> stacks = scans(testing::spherePhantom(80, 80, 5));
    stacks.resize(2);
    stacks[1] = simulateThickStack(changedBalls(from), 1, 4, 1.0, 2);
    displace(stacks[1], motion);
    return alignStacks(stacks, pool)[1];
  };
  const StackAlignment found = align(54);
  EXPECT_LT(found.correlation, 0.8);
  EXPECT_TRUE(found.fits);
  EXPECT_GT(found.psnrAfter, found.psnrBefore + 3);
  EXPECT_LT(distanceLeft(found, motion), 1);
  EXPECT_FALSE(align(20).fits) << "mostly another body";
}

} // namespace
} // namespace innergs
