#include "Evaluation/StacksProtocol.h"
#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/StackAlignment.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/Report.h"

#include "../Core/Alignment/HeadPhantom.h"
#include "../Core/ThrownError.h"

#include <gtest/gtest.h>

#include <tuple>

namespace innergs {
namespace {

StacksCase smallCase() {
  StacksCase c;
  c.thickness = 4;
  c.noise = 1;
  return c;
}

TEST(SimulatedStacks, AreThickStacksWhereNothingMoves) {
  ThreadPool pool(2);
  const Volume head = testing::headPhantom(32);
  StacksCase c = smallCase();
  c.noise = 0;
  const SimulatedStacks simulated = simulateStacks(head, c, pool);
  ASSERT_EQ(simulated.stacks.size(), 3u);
  const Stack plain = simulateThickStack(head, 2, 4);
  EXPECT_TRUE(sameGrid(plain.image.geometry, simulated.stacks[0].image.geometry));
  for (std::size_t v = 0; v < plain.image.voxels.size(); ++v)
    ASSERT_NEAR(plain.image.voxels[v], simulated.stacks[0].image.voxels[v], 0.01);
  EXPECT_EQ(simulated.poses[2][3], Affine3{});
}

TEST(SimulatedStacks, HavePixelsThatAverage) {
  ThreadPool pool(2);
  const Volume head = testing::headPhantom(32);
  StacksCase c = smallCase();
  c.noise = 0;
  const SimulatedStacks fine = simulateStacks(head, c, pool);
  c.pixels = {0, 2, 2};
  const SimulatedStacks wide = simulateStacks(head, c, pool);
  EXPECT_EQ(wide.stacks[0].image.voxels, fine.stacks[0].image.voxels);
  const Volume &from = fine.stacks[1].image, &to = wide.stacks[1].image;
  EXPECT_EQ(to.geometry.size, (std::array<std::int64_t, 3>{16, 16, 8}));
  EXPECT_EQ(to.geometry.spacing[0], 2);
  for (int a = 0; a < 3; ++a)
    EXPECT_NEAR(to.geometry.centre()[a], from.geometry.centre()[a], 1e-9);
  for (std::int64_t v = 0; v < to.geometry.voxelCount(); ++v) {
    const std::int64_t first = 2 * (v % 16) + 32 * (2 * (v / 16 % 16) + 32 * (v / 256));
    const float mean =
        (from.voxels[first] + from.voxels[first + 1] + from.voxels[first + 32] + from.voxels[first + 33]) / 4;
    ASSERT_NEAR(to.voxels[static_cast<std::size_t>(v)], mean, 0.01);
  }
  c.interpolated = true;
  const SimulatedStacks stored = simulateStacks(head, c, pool);
  EXPECT_TRUE(sameGrid(stored.stacks[1].image.geometry, from.geometry));
  c.pixels = {100};
  EXPECT_EQ(test::errorOf([&] { simulateStacks(head, c, pool); }).code(), ErrorCode::InvalidArgument);
}

TEST(SimulatedStacks, MoveShadeAndAreSeeded) {
  ThreadPool pool(2);
  const Volume head = testing::headPhantom(48);
  StacksCase c = smallCase();
  c.central = 32;
  c.motion = 2;
  c.turn = 3;
  c.gap = 1;
  c.shading = 0.4;
  const SimulatedStacks one = simulateStacks(head, c, pool), same = simulateStacks(head, c, pool);
  EXPECT_EQ(one.stacks[1].image.voxels, same.stacks[1].image.voxels);
  EXPECT_EQ(one.truth.geometry.size[0], 32);
  EXPECT_EQ(one.stacks[0].image.geometry.spacing[2], 5);
  EXPECT_EQ(one.stacks[0].thickness, 4);
  EXPECT_EQ(one.stacks[0].image.geometry.size[2], 6);
  c.seed = 2;
  EXPECT_NE(one.stacks[1].image.voxels, simulateStacks(head, c, pool).stacks[1].image.voxels);
  for (std::size_t k = 0; k < 6; ++k) {
    const Affine3& pose = one.poses[0][k];
    const Vec3 centre = one.stacks[0].image.geometry.indexToWorld()({15.5, 15.5, static_cast<double>(k)});
    for (const double d : pose(centre) - centre)
      EXPECT_LE(std::abs(d), 2.0001);
    EXPECT_LE(angleOf(pose.linear), 3 * 1.74);
    EXPECT_GT(angleOf(pose.linear), 0);
  }
}

TEST(SimulatedStacks, MoveInInterleavedPackets) {
  ThreadPool pool(2);
  const Volume head = testing::headPhantom(32);
  StacksCase c = smallCase();
  c.motion = c.turn = 2;
  const SimulatedStacks slices = simulateStacks(head, c, pool);
  c.motionPackets = 8;
  EXPECT_EQ(simulateStacks(head, c, pool).stacks[1].image.voxels, slices.stacks[1].image.voxels);
  c.motionPackets = 3;
  const SimulatedStacks packets = simulateStacks(head, c, pool);
  const std::vector<Affine3>& poses = packets.poses[1];
  ASSERT_EQ(poses.size(), 8u);
  for (std::size_t k = 3; k < poses.size(); ++k)
    EXPECT_EQ(poses[k], poses[k - 3]);
  EXPECT_NE(poses[0], poses[1]);
  const Vec3 centre = packets.stacks[1].image.geometry.indexToWorld()({15.5, 15.5, 2 + 1.5});
  for (const double d : poses[2](centre) - centre)
    EXPECT_LE(std::abs(d), 2.0001);
}

TEST(SimulatedStacks, RefuseWhatCannotBe) {
  ThreadPool pool(1);
  const Volume head = testing::headPhantom(24);
  const auto refused = [&](auto change) {
    StacksCase c = smallCase();
    change(c);
    return test::codeOf([&] { simulateStacks(head, c, pool); }) == ErrorCode::InvalidArgument;
  };
  EXPECT_TRUE(refused([](StacksCase& c) { c.stacks = 4; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.motion = -1; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.motionPackets = -1; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.thickness = 0; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.thickness = 20; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.central = 30; }));
  EXPECT_TRUE(refused([](StacksCase& c) { c.shading = 1; }));
}

TEST(PoseErrors, TakeAwayWhatIsCommonToAll) {
  ThreadPool pool(1);
  const Volume head = testing::headPhantom(32);
  StacksCase c = smallCase();
  c.motion = c.turn = 2;
  const SimulatedStacks simulated = simulateStacks(head, c, pool);
  const Mask body{head.geometry, std::vector<std::uint8_t>(head.voxels.size(), 1)};
  const Affine3 common = rigidAbout({10, 20, 5}, {0.02, 0.05, -0.01}, {1, -2, 0.5});
  auto found = simulated.poses;
  for (auto& stack : found)
    for (Affine3& pose : stack)
      pose = common * pose;
  PoseErrors errors = poseErrors(simulated.stacks, simulated.poses, found, body);
  EXPECT_LT(errors.millimetres.worst, 1e-6);
  EXPECT_LT(errors.degrees.worst, 1e-5);
  EXPECT_NEAR(errors.commonDegrees, angleOf(common.linear), 1e-6);
  found[1][4] = Affine3{{}, {1, 0, 0}} * found[1][4];
  errors = poseErrors(simulated.stacks, simulated.poses, found, body);
  EXPECT_NEAR(errors.millimetres.worst, 1, 0.1);
  EXPECT_LT(errors.millimetres.median, 0.1);
}

TEST(SimulatedStacks, OfAFewSlicesAreNotMovedByChance) {
  ThreadPool pool(2);
  StacksCase c;
  c.thickness = 5;
  for (const auto& [width, central, noise] : {std::tuple{32, 24, 2.}, {48, 28, 5.}, {48, 24, 10.}})
    for (c.seed = 1; c.seed <= 3; ++c.seed) {
      c.central = central;
      c.noise = noise;
      for (const StackAlignment& a :
           alignStacks(simulateStacks(testing::headPhantom(width), c, pool).stacks, pool)) {
        EXPECT_EQ(a.displacement, 0) << width << " mm, seed " << c.seed << ", " << a.psnrAfter << " dB";
        EXPECT_NEAR(a.gain, 1, 0.02);
      }
    }
}

TEST(SimulatedStacks, WithMovedSlicesAreScaledButNotTurnedByChance) {
  ThreadPool pool(2);
  StacksCase c = smallCase();
  c.motion = c.turn = 2;
  c.seed = 2;
  std::vector<Stack> stacks = simulateStacks(testing::headPhantom(44), c, pool).stacks;
  for (float& v : stacks[1].image.voxels)
    v *= 1.3f;
  const std::vector<StackAlignment> found = alignStacks(stacks, pool);
  EXPECT_NEAR(found[1].gain, 1 / 1.3, 0.04);
  for (const StackAlignment& a : found) {
    EXPECT_TRUE(a.fits);
    EXPECT_LT(a.angle, 5);
  }
}

TEST(StacksProtocol, ScoresShadingThatIsEvenedOut) {
  const Volume head = testing::headPhantom(48);
  StacksCase c = smallCase();
  c.shading = 0.4;
  EvaluationOptions options;
  options.settings.biasField = BiasFieldKind::Auto;
  options.settings.preset = Preset::Fast;
  options.settings.device = "cpu";
  const EvaluationReport report = evaluateStacks(head, c, options);
  const MethodScore &corrected = report.methods[0], &uncorrected = report.methods[1];
  ASSERT_EQ(uncorrected.name, "uncorrected");
  EXPECT_GT(corrected.psnr, uncorrected.psnr + 2);
  ASSERT_TRUE(corrected.bias && uncorrected.bias);
  EXPECT_GT(uncorrected.bias->between, 0.05);
  EXPECT_LT(corrected.bias->between, 0.03);
  const std::vector<EvaluationReport> reports{report};
  EXPECT_NE(textReport(reports).find("Shading left by gaussians: "), std::string::npos);
  EXPECT_NE(jsonReport(reports).find("\"bias_errors\""), std::string::npos);
}

TEST(StacksProtocol, LosesNothingByTakingShadingForMotion) {
  StacksCase c = smallCase();
  c.shading = 0.4;
  EvaluationOptions options;
  options.settings.preset = Preset::Fast;
  options.settings.device = "cpu";
  for (c.seed = 1; c.seed <= 2; ++c.seed) {
    const EvaluationReport report = evaluateStacks(testing::headPhantom(48), c, options);
    ASSERT_EQ(report.methods[1].name, "uncorrected");
    EXPECT_GT(report.methods[0].psnr, report.methods[1].psnr - 0.1) << "seed " << c.seed;
  }
}

TEST(StacksProtocol, ScoresWithAndWithoutCorrection) {
  const Volume head = testing::headPhantom(44); // so round that scans could be turned by chance
  StacksCase c = smallCase();
  c.motion = c.turn = 2;
  c.seed = 2;
  EvaluationOptions options;
  options.settings.preset = Preset::Fast;
  options.settings.device = "cpu";
  const EvaluationReport report = evaluateStacks(head, c, options);
  const auto psnr = [&](const std::string& name) {
    for (const MethodScore& method : report.methods)
      if (method.name == name) return method.psnr;
    ADD_FAILURE() << name;
    return 0.0;
  };
  EXPECT_GT(psnr("gaussians"), psnr("uncorrected") + 3);
  EXPECT_GT(psnr("gaussians"), psnr("average") + 3);
  EXPECT_GT(psnr("gaussians"), psnr("backprojection") + 3);
  EXPECT_GT(psnr("linear"), 5);
  EXPECT_GT(psnr("cubic"), 5);
  ASSERT_TRUE(report.methods[0].poses);
  EXPECT_LT(report.methods[0].poses->millimetres.median, 0.6);
  EXPECT_GT(report.methods[1].poses->millimetres.median, 1.5);
  const std::vector<EvaluationReport> reports{report};
  EXPECT_NE(textReport(reports).find("Poses of gaussians: median"), std::string::npos);
  EXPECT_NE(jsonReport(reports).find("\"pose_errors\""), std::string::npos);
}

} // namespace
} // namespace innergs
