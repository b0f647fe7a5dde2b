#include "Core/Alignment/SliceMotion.h"

#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/SamplePlaces.h"
#include "Core/Alignment/SliceVolume.h"
#include "Core/Image/CubicConvolution.h"
#include "Core/Image/Simulate.h"
#include "HeadPhantom.h"
#include "TestVolumes.h"
#include "ThrownError.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

namespace innergs {
namespace {

constexpr std::int64_t kWidth = 56;
constexpr double kDegree = std::numbers::pi / 180;

/// Scans of `thickness` mm slices at right angles, with `width` pixels of 1 mm along each side; each slice,
/// or each interleaved packet of slices, displaced by up to ± `most` mm along each axis and turned by up to ±
/// `most` degrees. `stacks` keep the true poses.
std::vector<Stack> movingScans(int count, double most, double noise = 1, std::int64_t packets = 0,
                               int thickness = 4, std::int64_t width = kWidth) {
  const Volume truth = testing::headPhantom(width);
  ThreadPool pool(2);
  Random random(11);
  const auto even = [&] { return 2 * random.uniform() - 1; };
  std::vector<Stack> stacks;
  for (int s = 0; s < count; ++s) {
    Stack stack = simulateThickStack(truth, 2 - s, thickness);
    const GridGeometry& g = stack.image.geometry;
    for (std::int64_t k = 0; k < g.size[2]; ++k) {
      if (packets > 0 && k >= packets) {
        const Affine3 pose = stack.poses[static_cast<std::size_t>(k % packets)];
        stack.poses.push_back(pose);
        continue;
      }
      const Vec3 shift{most * even(), most * even(), most * even()},
          turn{most * kDegree * even(), most * kDegree * even(), most * kDegree * even()};
      const Vec3 centre = g.indexToWorld()({0.5 * static_cast<double>(width - 1),
                                            0.5 * static_cast<double>(width - 1), static_cast<double>(k)});
      stack.poses.push_back(most > 0 ? rigidAbout(centre, turn, shift) : Affine3{});
    }
    std::vector<float> seen = projectToStack(truth, stack, pool);
    for (float& v : seen)
      v = v > 0 ? v : 0; // cubic convolution overshoots beside edges, magnitudes are never negative
    stack.image.voxels = std::move(seen);
    addNoise(stack.image.voxels, noise, static_cast<std::uint64_t>(s) + 1);
    stacks.push_back(std::move(stack));
  }
  return stacks;
}

std::vector<Stack> withoutPoses(std::vector<Stack> stacks) {
  for (Stack& stack : stacks)
    stack.poses.clear();
  return stacks;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// mm in the middle of each slice that lies well within the head.
std::vector<double> errors(const std::vector<Stack>& stacks, const SliceMotion& motion) {
  std::vector<double> found;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    for (std::size_t k = 3; k + 3 < stacks[s].poses.size(); ++k) {
      const Vec3 middle =
          stacks[s].image.geometry.indexToWorld()({0.5 * kWidth, 0.5 * kWidth, static_cast<double>(k)});
      found.push_back(norm(motion.slices[s][k].pose(middle) - stacks[s].poses[k](middle)));
    }
  return found;
}

/// The same once the mean shift between found and true, which no method can know, is removed.
double spread(const std::vector<Stack>& stacks, const SliceMotion& motion) {
  const Vec3 centre = stacks.front().image.geometry.centre();
  std::vector<Vec3> off;
  Vec3 mean{};
  for (std::size_t s = 0; s < stacks.size(); ++s)
    for (std::size_t k = 0; k < stacks[s].poses.size(); ++k) {
      off.push_back(motion.slices[s][k].pose(inverse(stacks[s].poses[k])(centre)) - centre);
      mean = mean + off.back();
    }
  std::vector<double> found;
  for (const Vec3& d : off)
    found.push_back(norm(d - (1 / static_cast<double>(off.size())) * mean));
  return median(found);
}

TEST(Rigid, RotationVectorsTurnBack) {
  for (const Vec3& turn : {Vec3{0.3, -0.2, 0.1}, Vec3{0, 0, 0}, Vec3{1e-9, 0, 0}, Vec3{2, 1, -1}}) {
    EXPECT_LT(norm(rotationVector(rotation(turn)) - turn), 1e-12);
    EXPECT_NEAR(determinant(rotation(turn)), 1, 1e-12);
  }
  EXPECT_NEAR(angleOf(rotation({0, 0, 5 * kDegree})), 5, 1e-9);
  const Vec3 centre{1, 2, 3};
  EXPECT_LT(norm(rigidAbout(centre, {0.1, 0.2, 0.3}, {4, 5, 6})(centre) - Vec3{5, 7, 9}), 1e-12);
}

/// One slice of the phantom, and a volume to look at.
struct SliceCase {
  GridGeometry grid;
  std::vector<float> volume;
  PlacedSlice slice;

  explicit SliceCase(bool leftHanded = false) {
    grid.size = {30, 28, 26};
    grid.spacing = {1.5, 1.5, 1.5};
    grid.direction = rotation({0.2, -0.3, 0.4});
    if (leftHanded)
      for (int a = 0; a < 3; ++a)
        grid.direction[a][0] = -grid.direction[a][0];
    grid.origin = {4, -7, 2};
    Random random(3);
    volume.resize(static_cast<std::size_t>(grid.voxelCount()));
    for (float& v : volume)
      v = static_cast<float>(random.uniform());
    slice.nx = 17;
    slice.ny = 15;
    slice.values.resize(17 * 15);
    for (float& v : slice.values)
      v = static_cast<float>(random.uniform());
    slice.values[20] = std::nanf("");
    slice.profile = profileQuadrature(SliceProfile::Box, 5, 1.5);
    slice.normal = column(rotation({-0.5, 0.1, 0.2}), 2);
    slice.toWorld.linear = rotation({-0.5, 0.1, 0.2}) * diagonal({1.3, 1.3, 5});
    slice.toWorld.offset = grid.centre() - slice.toWorld.linear * Vec3{8, 7, 0};
    slice.pose = rigidAbout(grid.centre(), {0.05, 0.02, -0.1}, {1, -2, 0.5});
  }
};

TEST(SliceOperator, AddsItsTranspose) {
  const SliceCase c;
  ThreadPool pool(3);
  const SliceOperator op(c.grid, pool);
  const std::vector<float> seen = op.project(c.volume, c.slice);
  EXPECT_TRUE(std::isnan(seen[20]));
  std::vector<std::vector<float>> images{c.slice.values};
  double forward = 0, backward = 0;
  int count = 0;
  for (std::size_t p = 0; p < seen.size(); ++p) {
    if (std::isnan(seen[p])) {
      images[0][p] = 0;
      continue;
    }
    forward += static_cast<double>(seen[p]) * images[0][p];
    ++count;
  }
  ASSERT_GT(count, 200);
  std::vector<float> spread(c.volume.size());
  const PlacedSlice* slices[] = {&c.slice};
  op.addTransposed(slices, images, spread);
  for (std::size_t v = 0; v < spread.size(); ++v)
    backward += static_cast<double>(spread[v]) * c.volume[v];
  EXPECT_NEAR(forward, backward, 1e-4 * forward);
}

TEST(SliceOperator, ReadsGradientsOfAPose) {
  for (const bool leftHanded : {false, true}) {
    SliceCase c(leftHanded);
    ThreadPool pool(1);
    const SliceOperator op(c.grid, pool);
    for (std::size_t v = 0; v < c.volume.size(); ++v) { // smooth: the interpolation has no kinks
      const auto at = static_cast<std::int64_t>(v);
      const Vec3 x = c.grid.indexToWorld()(
          {static_cast<double>(at % 30), static_cast<double>(at / 30 % 28), static_cast<double>(at / 840)});
      c.volume[v] = static_cast<float>(3 * x[0] - 2 * x[1] + 5 * x[2]);
    }
    const Vec3 centre = c.grid.centre();
    SliceOperator::Sample seen;
    ASSERT_TRUE(SliceOperator::Reader(op, c.volume, c.slice, c.slice.pose, centre).at(5, 6, seen));
    EXPECT_LT(norm(seen.shift - Vec3{3, -2, 5}), 1e-3);
    for (int a = 0; a < 3; ++a) {
      Vec3 turn{};
      turn[a] = 1e-3;
      SliceOperator::Sample turned;
      const Affine3 pose = rigidAbout(centre, turn, {}) * c.slice.pose;
      ASSERT_TRUE(SliceOperator::Reader(op, c.volume, c.slice, pose, centre).at(5, 6, turned));
      EXPECT_NEAR((turned.value - seen.value) / 1e-3, seen.turn[a], 0.1) << a << leftHanded;
    }
  }
}

TEST(SliceVolume, ExplainsItsSlices) {
  ThreadPool pool(2);
  const Volume truth = testing::headPhantom(40);
  const SliceOperator op(truth.geometry, pool);
  std::vector<PlacedSlice> slices;
  for (int axis = 0; axis < 3; ++axis) {
    const Stack stack = simulateThickStack(truth, axis, 4);
    const GridGeometry& g = stack.image.geometry;
    for (std::int64_t k = 0; k < g.size[2]; ++k) {
      PlacedSlice& s = slices.emplace_back();
      s.nx = s.ny = 40;
      s.observed = 1600;
      s.toWorld = g.indexToWorld();
      s.toWorld.offset = g.indexToWorld()({0, 0, static_cast<double>(k)});
      s.normal = column(g.direction, 2);
      s.profile = profileQuadrature(SliceProfile::Box, 4, 1);
      s.values.assign(stack.image.voxels.begin() + 1600 * k, stack.image.voxels.begin() + 1600 * (k + 1));
    }
  }
  std::vector<const PlacedSlice*> views;
  for (const PlacedSlice& s : slices)
    views.push_back(&s);
  std::vector<float> volume;
  fitVolume(volume, op, views, {0.01, 40}, pool);
  double squares = 0, all = 0;
  for (std::size_t v = 0; v < volume.size(); ++v) {
    squares += std::pow(volume[v] - truth.voxels[v], 2);
    all += std::pow(truth.voxels[v], 2);
  }
  EXPECT_LT(squares, 0.02 * all);
}

TEST(SliceMotion, FindsWhereSlicesLie) {
  ThreadPool pool(2);
  const std::vector<Stack> stacks = movingScans(3, 2);
  const SliceMotion motion = findSliceMotion(withoutPoses(stacks), {}, pool);
  EXPECT_TRUE(motion.moved);
  EXPECT_GT(motion.psnrAfter, motion.psnrBefore + 3);
  // The mean of so few motions is not none, and no method can know it.
  EXPECT_LT(median(errors(stacks, motion)), 0.75);
  EXPECT_LT(motion.rejected, 3);
  EXPECT_NE(sliceMotionSentence(motion, {}).find("moved one by one"), std::string::npos);
  std::vector<Stack> placed = withoutPoses(stacks);
  applySliceMotion(motion, placed);
  EXPECT_EQ(placed[1].poses[4], motion.slices[1][4].pose);
}

TEST(SliceMotion, FindsSlicesAsThinAsTheirPixels) {
  ThreadPool pool(2);
  const std::vector<Stack> truth = movingScans(3, 2, 1, 0, 1, 48), still = movingScans(3, 0, 10, 0, 1, 48);
  const SliceMotion motion = findSliceMotion(withoutPoses(truth), {}, pool);
  EXPECT_TRUE(motion.moved);
  EXPECT_LT(spread(truth, motion), 0.5);
  EXPECT_FALSE(findSliceMotion(withoutPoses(still), {}, pool).moved);
}

TEST(SliceMotion, OfPacketsIsFoundBetterTogether) {
  ThreadPool pool(2);
  const std::vector<Stack> stacks = movingScans(3, 2, 4, 2);
  const SliceMotion packets = findSliceMotion(withoutPoses(stacks), {.packets = 2}, pool),
                    slices = findSliceMotion(withoutPoses(stacks), {}, pool);
  ASSERT_TRUE(packets.moved);
  for (const auto& stack : packets.slices)
    for (std::size_t k = 2; k < stack.size(); ++k)
      EXPECT_EQ(stack[k].pose, stack[k - 2].pose);
  EXPECT_NE(packets.slices[0][0].pose, packets.slices[0][1].pose);
  EXPECT_LT(spread(stacks, packets), 0.15);
  EXPECT_LT(spread(stacks, packets), 0.5 * spread(stacks, slices));
  EXPECT_NE(sliceMotionSentence(packets, {}).find("in 2 interleaved packets,"), std::string::npos)
      << sliceMotionSentence(packets, {});
}

TEST(SliceMotion, OfOnePacketIsThatOfTheScan) {
  ThreadPool pool(2);
  const std::vector<Stack> stacks = movingScans(3, 2, 1, 1);
  const SliceMotion motion = findSliceMotion(withoutPoses(stacks), {.packets = 1}, pool);
  EXPECT_EQ(motion.slices[2].front().pose, motion.slices[2].back().pose);
  EXPECT_LT(spread(stacks, motion), 0.15);
  EXPECT_NE(sliceMotionSentence(motion, {}).find("moved together,"), std::string::npos);
}

TEST(SliceMotion, OfPacketsOfOneSliceIsThatOfSlices) {
  ThreadPool pool(2);
  const std::vector<Stack> stacks = withoutPoses(movingScans(2, 1));
  const auto slices = static_cast<int>(stacks.front().image.geometry.size[2]);
  const SliceMotion alone = findSliceMotion(stacks, {.always = true}, pool);
  for (const int packets : {slices, 1000}) {
    const SliceMotion motion = findSliceMotion(stacks, {.always = true, .packets = packets}, pool);
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t k = 0; k < alone.slices[s].size(); ++k) {
        EXPECT_EQ(motion.slices[s][k].pose, alone.slices[s][k].pose);
        EXPECT_EQ(motion.slices[s][k].gain, alone.slices[s][k].gain);
      }
    EXPECT_EQ(motion.psnrAfter, alone.psnrAfter);
    EXPECT_EQ(motion.packets, 0);
  }
}

TEST(SliceMotion, OfPacketsIsTheSameByAnyNumberOfThreads) {
  const std::vector<Stack> stacks = withoutPoses(movingScans(2, 1, 1, 3));
  std::vector<SliceMotion> found;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    found.push_back(findSliceMotion(stacks, {.always = true, .packets = 3}, pool));
  }
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(found[0].slices[1][k].pose, found[1].slices[1][k].pose);
  EXPECT_EQ(found[0].psnrAfter, found[1].psnrAfter);
}

// Each slice keeps a gain and a weight of its own, and one that fits nowhere does not pull its packet away.
TEST(SliceMotion, OfPacketsLeavesOutASliceThatFitsNowhere) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = movingScans(3, 2, 1, 2);
  const std::int64_t plane = kWidth * kWidth;
  for (std::int64_t v = 6 * plane; v < 7 * plane; ++v)
    stacks[1].image.voxels[v] = static_cast<float>(v / 5 % 3) * 90;
  for (std::int64_t v = 7 * plane; v < 8 * plane; ++v)
    stacks[1].image.voxels[v] *= 1.2f;
  const SliceMotion motion = findSliceMotion(withoutPoses(stacks), {.packets = 2}, pool);
  ASSERT_TRUE(motion.moved);
  EXPECT_EQ(motion.slices[1][6].weight, 0);
  EXPECT_GT(motion.slices[1][4].weight, 0);
  EXPECT_EQ(motion.slices[1][6].pose, motion.slices[1][4].pose);
  EXPECT_NEAR(motion.slices[1][7].gain / motion.slices[1][5].gain, 1 / 1.2, 0.02);
  EXPECT_LT(spread(stacks, motion), 0.2);
}

TEST(SliceMotion, LeavesStillSlicesAlone) {
  ThreadPool pool(2);
  for (const int count : {2, 3})
    for (const int packets : {0, 2}) {
      const std::vector<Stack> stacks = withoutPoses(movingScans(count, 0));
      const SliceMotion motion = findSliceMotion(stacks, {.packets = packets}, pool);
      EXPECT_FALSE(motion.moved) << count << ": " << motion.psnrBefore << " to " << motion.psnrAfter << " dB";
      EXPECT_EQ(sliceMotionSentence(motion, {}), "");
      for (const auto& stack : motion.slices)
        for (const SlicePose& slice : stack) {
          EXPECT_EQ(slice.pose, Affine3{});
          EXPECT_EQ(slice.gain, 1);
          EXPECT_EQ(slice.weight, 1);
        }
    }
}

/// Boxes of labels 1 to 117 in air.
Volume labelBoxes(std::int64_t width) {
  Volume labels = testing::headPhantom(width);
  std::fill(labels.voxels.begin(), labels.voxels.end(), 0.f);
  Random random(5);
  const auto upTo = [&](double most) { return static_cast<std::int64_t>(most * random.uniform()); };
  for (int n = 0; n < 40; ++n) {
    const std::int64_t side = 3 + upTo(8), room = width - side - 8;
    const std::int64_t from[] = {4 + upTo(room), 4 + upTo(room), 4 + upTo(room)};
    const auto label = static_cast<float>(1 + upTo(117));
    for (std::int64_t k = from[2]; k < from[2] + side; ++k)
      for (std::int64_t j = from[1]; j < from[1] + side; ++j)
        std::fill_n(labels.voxels.begin() + (k * width + j) * width + from[0], side, label);
  }
  return labels;
}

TEST(SliceMotion, NeverLetsGainsOfNearlyEmptySlicesRunAway) {
  const Volume labels = labelBoxes(kWidth);
  const std::vector<Stack> stacks{simulateThickStack(labels, 2, 4), simulateThickStack(labels, 1, 4)};
  ThreadPool pool(2);
  const SliceMotion motion = findSliceMotion(stacks, {true}, pool);
  for (const auto& slices : motion.slices)
    for (const SlicePose& pose : slices) {
      EXPECT_GT(pose.gain, 0.4);
      EXPECT_LT(pose.gain, 2.5);
    }
}

TEST(SliceMotion, LeavesOutASliceThatFitsNowhere) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = withoutPoses(movingScans(3, 2));
  const std::int64_t plane = kWidth * kWidth;
  for (std::int64_t v = 6 * plane; v < 7 * plane; ++v)
    stacks[1].image.voxels[v] = static_cast<float>(v / 5 % 3) * 90;
  const SliceMotion motion = findSliceMotion(stacks, {}, pool);
  EXPECT_EQ(motion.slices[1][6].weight, 0);
  EXPECT_GE(motion.rejected, 1);
  EXPECT_LT(motion.rejected, 4);
  const std::vector<std::string> names{"ax", "cor", "sag"};
  const std::string said = sliceMotionSentence(motion, names);
  EXPECT_NE(said.find("Left out, as they fit no other: slice"), std::string::npos) << said;
  EXPECT_NE(said.find(" 6 of cor"), std::string::npos) << said;
  applySliceMotion(motion, stacks);
  EXPECT_EQ(stacks[1].observed[6 * plane], 0);
  EXPECT_EQ(stacks[1].observed[7 * plane], 1);
}

TEST(SliceMotion, ListsAtMostTenSlicesAndThoseThatWentFar) {
  SliceMotion motion;
  motion.moved = true;
  motion.displacement = 1;
  motion.slices.assign(2, std::vector<SlicePose>(12));
  for (auto& stack : motion.slices)
    for (SlicePose& slice : stack)
      slice.weight = 0;
  motion.slices[0][0].weight = motion.slices[1][1].weight = 1;
  motion.slices[0][0].displacement = 4.5;
  motion.slices[1][1].displacement = 3.5;
  motion.slices[1][2].weight = 0.3;
  const std::vector<std::string> names{"ax", "cor"};
  const std::string said = sliceMotionSentence(motion, names);
  EXPECT_NE(
      said.find("fit no other: slices 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 of ax and 11 more (counted from 0)."),
      std::string::npos)
      << said;
  EXPECT_NE(said.find("for less than half, as they fit badly: slice 2 of cor"), std::string::npos) << said;
  EXPECT_NE(said.find("Moved or turned much farther than the others: slice 0 of ax (counted"),
            std::string::npos)
      << said;
  motion.slices[1][1].angle = 10; // degrees; half of the slices by less than 2
  motion.angle = 2;
  EXPECT_NE(sliceMotionSentence(motion, names).find("the others: slices 0 of ax and 1 of cor"),
            std::string::npos)
      << sliceMotionSentence(motion, names);
  motion.angle = 2.5;
  EXPECT_NE(sliceMotionSentence(motion, names).find("the others: slice 0 of ax (counted"), std::string::npos);
}

TEST(SliceMotion, IsTheSameByAnyNumberOfThreadsAndStops) {
  const std::vector<Stack> stacks = withoutPoses(movingScans(2, 1));
  std::vector<SliceMotion> found;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    found.push_back(findSliceMotion(stacks, {.always = true}, pool));
  }
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t k = 0; k < found[0].slices[s].size(); ++k) {
      EXPECT_EQ(found[0].slices[s][k].pose, found[1].slices[s][k].pose);
      EXPECT_EQ(found[0].slices[s][k].gain, found[1].slices[s][k].gain);
    }
  EXPECT_EQ(found[0].psnrAfter, found[1].psnrAfter);
  ThreadPool pool(2);
  std::stop_source source;
  pool.setStop(source.get_token());
  const auto stop = [&](double) { source.request_stop(); };
  EXPECT_EQ(test::codeOf([&] { findSliceMotion(stacks, {.always = true}, pool, stop); }),
            ErrorCode::Cancelled);
}

TEST(SliceMotion, NeverLooksAtUnobservedVoxels) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = withoutPoses(movingScans(2, 1));
  const std::int64_t plane = kWidth * kWidth;
  testing::holdOut(stacks[0], {5});
  const SliceMotion before = findSliceMotion(stacks, {.always = true}, pool);
  for (std::int64_t v = 5 * plane; v < 6 * plane; ++v)
    stacks[0].image.voxels[v] = v % 2 ? 1e6f : std::nanf("");
  const SliceMotion after = findSliceMotion(stacks, {.always = true}, pool);
  EXPECT_EQ(before.slices[1][6].pose, after.slices[1][6].pose);
  EXPECT_EQ(before.psnrAfter, after.psnrAfter);
}

TEST(SliceMotion, LooksOnlyWhereVoxelsAreObserved) {
  Stack stack;
  stack.image.geometry.size = {9, 8, 7};
  stack.image.geometry.spacing = {1, 2, 4};
  stack.image.geometry.direction = rotation({0.2, -0.3, 0.4});
  stack.image.voxels.assign(9 * 8 * 7, 1.f);
  const auto at = [](int i, int j, int k) { return i + 9 * (j + 8 * k); };
  EXPECT_EQ(observedBoxes({&stack, 1}).front(), stack.image.geometry);
  stack.observed.assign(stack.image.voxels.size(), 0);
  EXPECT_EQ(observedBoxes({&stack, 1}).front(), stack.image.geometry);
  stack.observed[at(2, 3, 1)] = stack.observed[at(5, 3, 4)] = stack.observed[at(8, 7, 6)] = 1;
  stack.image.voxels[at(8, 7, 6)] = std::nanf("");
  const GridGeometry box = observedBoxes({&stack, 1}).front();
  EXPECT_EQ(box, cropped(stack.image.geometry, {2, 3, 1}, {4, 1, 4}));
  const GridGeometry around = gridAround({&box, 1}, 1, 3);
  EXPECT_EQ(around.size, (std::array<std::int64_t, 3>{11, 9, 23}));
  EXPECT_LT(norm(around.origin - box.indexToWorld()({-3.5, -2, -1.25})), 1e-9);
}

// A mask around the head keeps what lies around it out of the volume that slices are registered to.
TEST(SliceMotion, FindsMaskedSlicesAlone) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = movingScans(3, 2), alone;
  for (Stack& stack : stacks) {
    const GridGeometry g = stack.image.geometry;
    const std::array<std::int64_t, 3> low{8, 8, 2}, size{kWidth - 16, kWidth - 16, g.size[2] - 4};
    stack.observed.assign(stack.image.voxels.size(), 0);
    Stack& part = alone.emplace_back();
    part.thickness = stack.thickness;
    part.image.geometry = cropped(g, low, size);
    for (std::int64_t v = 0; v < part.image.geometry.voxelCount(); ++v) {
      const std::int64_t from = low[0] + v % size[0] + g.size[0] * (low[1] + v / size[0] % size[1]) +
                                g.size[0] * g.size[1] * (low[2] + v / (size[0] * size[1]));
      stack.observed[from] = 1;
      part.image.voxels.push_back(stack.image.voxels[from]);
    }
  }
  const SliceMotion masked = findSliceMotion(withoutPoses(stacks), {.always = true}, pool),
                    cut = findSliceMotion(alone, {.always = true}, pool);
  EXPECT_NEAR(masked.psnrBefore, cut.psnrBefore, 1e-6);
  EXPECT_NEAR(masked.psnrAfter, cut.psnrAfter, 0.2); // rounding: many turns of round things fit as well
  for (const auto& slices : masked.slices)
    EXPECT_EQ(slices.front().displacement > 0, slices.front().angle > 0) << "of a slice outside the mask";
}

TEST(SliceMotion, PlacesSlicesThatTookNoPart) {
  ThreadPool pool(2);
  const Volume truth = testing::headPhantom(kWidth);
  const std::vector<Stack> stacks = movingScans(1, 2);
  const Affine3 toIndex = inverse(truth.geometry.indexToWorld());
  const auto render = [&](const GridGeometry& grid) {
    Volume volume{grid, {}};
    for (std::int64_t v = 0; v < grid.voxelCount(); ++v) {
      const Vec3 x = toIndex(grid.indexToWorld()({static_cast<double>(v % grid.size[0]),
                                                  static_cast<double>(v / grid.size[0] % grid.size[1]),
                                                  static_cast<double>(v / (grid.size[0] * grid.size[1]))}));
      volume.voxels.push_back(cubicAt(truth, x));
    }
    return volume;
  };
  const std::vector<std::int64_t> slices{5, 7, 8};
  const auto placed = placeSlices(render, withoutPoses(stacks).front(), slices, true, pool);
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const Vec3 middle =
        stacks[0].image.geometry.indexToWorld()({0.5 * kWidth, 0.5 * kWidth, static_cast<double>(slices[n])});
    EXPECT_LT(norm(placed[n].pose(middle) - stacks[0].poses[slices[n]](middle)), 0.4) << n;
    EXPECT_NEAR(placed[n].gain, 1, 0.02);
  }
}

} // namespace
} // namespace innergs
