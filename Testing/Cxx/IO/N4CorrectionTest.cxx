#include "IO/N4Correction.h"

#include "../Core/ThrownError.h"
#include "Core/Job/ReconstructionJob.h"

#include <gtest/gtest.h>

#include <cmath>

namespace innergs {
namespace {

/// A ball of two tissues on nothing, 3 mm slices of 2 mm pixels, and by how much every voxel is shaded.
struct Shaded {
  Stack stack;
  std::vector<float> truth;
};

Shaded shadedBall(double strength) {
  Shaded s;
  GridGeometry& g = s.stack.image.geometry;
  g.size = {48, 48, 32};
  g.spacing = {2, 2, 3};
  for (std::int64_t k = 0; k < 32; ++k)
    for (std::int64_t j = 0; j < 48; ++j)
      for (std::int64_t i = 0; i < 48; ++i) {
        const double x = (i - 23.5) / 24, y = (j - 23.5) / 24, z = (k - 15.5) / 16;
        const double r = std::sqrt(x * x + y * y + z * z);
        const double tissue = r > 0.9                                                     ? 0
                              : std::sin(9 * x) * std::sin(8 * y) * std::sin(7 * z) > 0.1 ? 600
                                                                                          : 400;
        s.truth.push_back(static_cast<float>(tissue));
        s.stack.image.voxels.push_back(static_cast<float>(tissue * std::exp(strength * (x - 0.5 * y * y))));
      }
  s.stack.name = "ball";
  return s;
}

/// Standard deviation of the logarithm of what is left of the shading, in the ball.
double left(const Shaded& s) {
  double sum = 0, squares = 0, count = 0;
  for (std::size_t v = 0; v < s.truth.size(); ++v) {
    if (s.truth[v] == 0) continue;
    const double x = std::log(s.stack.image.voxels[v] / s.truth[v]);
    sum += x;
    squares += x * x;
    ++count;
  }
  return std::sqrt(squares / count - sum * sum / (count * count));
}

TEST(N4Correction, EvensOutAShadedBall) {
  Shaded s = shadedBall(0.3);
  const double before = left(s);
  const std::string said = correctByN4(s.stack, false);
  EXPECT_LT(left(s), 0.25 * before) << said;
  EXPECT_NE(said.find("N4 corrected ball"), std::string::npos) << said;
  EXPECT_EQ(s.stack.image.voxels.front(), 0.f);
}

TEST(N4Correction, LeavesWhatIsFlat) {
  Shaded s = shadedBall(0);
  correctByN4(s.stack, false);
  EXPECT_LT(left(s), 0.01);
}

TEST(N4Correction, LooksAtObservedVoxelsAlone) {
  Shaded s = shadedBall(0.3), same = s;
  const std::size_t plane = 48 * 48;
  s.stack.observed.assign(s.truth.size(), 1);
  for (std::size_t k = 5; k < 32; k += 5)
    std::fill_n(s.stack.observed.begin() + static_cast<std::ptrdiff_t>(k * plane), plane, std::uint8_t{0});
  same.stack.observed = s.stack.observed;
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (!s.stack.observed[v]) same.stack.image.voxels[v] = 1e4f;
  const std::string one = correctByN4(s.stack, false), two = correctByN4(same.stack, false);
  EXPECT_EQ(one, two);
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (s.stack.observed[v]) {
      ASSERT_EQ(s.stack.image.voxels[v], same.stack.image.voxels[v]) << v;
    }
  EXPECT_LT(left(s), 0.1);
}

TEST(N4Correction, SaysWhyItDoesNothing) {
  Shaded s = shadedBall(0.3);
  s.stack.image.voxels[0] = -1000;
  const std::vector<float> voxels = s.stack.image.voxels;
  EXPECT_NE(correctByN4(s.stack, false).find("values far below zero"), std::string::npos);
  s.stack.image.voxels[0] = 0;
  s.stack.poses.assign(32, Affine3{});
  EXPECT_NE(correctByN4(s.stack, false).find("poses"), std::string::npos);
  s.stack.poses.clear();
  s.stack.observed.assign(voxels.size(), 0);
  EXPECT_NE(correctByN4(s.stack, true).find("too few"), std::string::npos);
  EXPECT_TRUE(std::equal(voxels.begin() + 1, voxels.end(), s.stack.image.voxels.begin() + 1));
}

TEST(N4Correction, Stops) {
  Shaded s = shadedBall(0.3);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(test::codeOf([&] { correctByN4(s.stack, false, stop.get_token()); }), ErrorCode::Cancelled);
}

TEST(N4Correction, TakesPartInAReconstruction) {
  Shaded s = shadedBall(0.3);
  Settings settings;
  settings.preset = Preset::Fast;
  settings.prediction = PredictionKind::None;
  settings.n4 = true;
  settings.iterations = 15;
  ReconstructionInput input;
  input.stacks = {s.stack};
  input.outputGrid = s.stack.image.geometry;
  input.heldOutFraction = 0.2;
  EXPECT_EQ(test::codeOf([&] { ReconstructionJob(input, settings).run(); }), ErrorCode::InvalidArgument)
      << "there is no N4";
  input.n4 = correctByN4;
  const ReconstructionResult result = ReconstructionJob(input, settings).run();
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.front().find("N4"), std::string::npos) << result.warnings.front();
  // Held-out slices are judged as N4 has them: with its shading left in, they would differ by more.
  EXPECT_GT(result.heldOutPsnr, 17);
  double inside = 0, count = 0, off = 0;
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (s.truth[v] > 0) {
      inside += result.volume.voxels[v] / s.truth[v];
      ++count;
    }
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (s.truth[v] > 0) off += std::pow(result.volume.voxels[v] / s.truth[v] / (inside / count) - 1, 2);
  Shaded plain = s;
  settings.n4 = false;
  const ReconstructionResult uneven = ReconstructionJob(input, settings).run();
  double unevenOff = 0, unevenMean = 0;
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (s.truth[v] > 0) unevenMean += uneven.volume.voxels[v] / s.truth[v] / count;
  for (std::size_t v = 0; v < s.truth.size(); ++v)
    if (s.truth[v] > 0) unevenOff += std::pow(uneven.volume.voxels[v] / s.truth[v] / unevenMean - 1, 2);
  EXPECT_LT(off, 0.5 * unevenOff);
}

} // namespace
} // namespace innergs
