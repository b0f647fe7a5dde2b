#include "Core/Features/ClassProbabilities.h"
#include "Core/Base/Error.h"
#include "Core/Features/FeatureTraining.h"
#include "Features/BoxPhantom.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace innergs::testing {
namespace {

class ClassProbabilitiesTest : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    phantom = new BoxPhantom;
    model = new FeatureModel(
        trainFeatures(phantom->field, phantom->labels, {{1, "liver"}, {2, "spleen"}, {3, "kidney_left"}}));
  }
  static void TearDownTestSuite() {
    delete phantom;
    delete model;
  }
  static ClassProbabilities encoded(const GridGeometry& grid, int threads = 0) {
    FeatureQueryOptions options;
    options.threads = threads;
    return {phantom->field, *model, grid, options};
  }
  static Segment segmentOf(std::vector<int> classes, const SegmentOptions& options = {}) {
    return encoded(phantom->labels.geometry).segment(classes, options);
  }
  /// Of the whole grid.
  static std::vector<std::uint8_t> onGrid(const Segment& s) {
    const auto& n = phantom->labels.geometry.size;
    std::vector<std::uint8_t> all(phantom->labels.voxels.size(), 0);
    std::size_t at = 0;
    for (std::int64_t k = 0; k < s.geometry.size[2]; ++k)
      for (std::int64_t j = 0; j < s.geometry.size[1]; ++j)
        for (std::int64_t i = 0; i < s.geometry.size[0]; ++i, ++at)
          all[static_cast<std::size_t>(s.first[0] + i + n[0] * (s.first[1] + j + n[1] * (s.first[2] + k)))] =
              s.mask[at];
    return all;
  }
  static BoxPhantom* phantom;
  static FeatureModel* model;
};
BoxPhantom* ClassProbabilitiesTest::phantom = nullptr;
FeatureModel* ClassProbabilitiesTest::model = nullptr;

TEST_F(ClassProbabilitiesTest, SegmentsAreWhatClassifyGives) {
  const ClassImage image = classify(phantom->field, *model, phantom->labels.geometry);
  for (const auto& classes : {std::vector<int>{1}, {2}, {3}, {1, 3}}) {
    const Segment s = segmentOf(classes);
    const auto mask = onGrid(s);
    std::int64_t voxels = 0;
    for (std::size_t v = 0; v < mask.size(); ++v) {
      ASSERT_EQ(mask[v], std::count(classes.begin(), classes.end(), image.classes[v])) << v;
      voxels += mask[v];
    }
    EXPECT_EQ(s.voxels, voxels);
    EXPECT_EQ(s.probability.size(), s.mask.size());
  }
  GridGeometry oblique = phantom->labels.geometry;
  oblique.direction = oblique.direction * Mat3{{{{0.8, -0.6, 0}, {0.6, 0.8, 0}, {0, 0, 1}}}};
  const ClassImage turned = classify(phantom->field, *model, oblique);
  EXPECT_EQ(encoded(oblique).segment(std::vector<int>{1}).voxels,
            std::count(turned.classes.begin(), turned.classes.end(), 1));
  oblique.origin[2] += 1000;
  const Segment nowhere = encoded(oblique).segment(std::vector<int>{1});
  EXPECT_EQ(nowhere.voxels, 0);
  EXPECT_TRUE(nowhere.mask.empty());
}

TEST_F(ClassProbabilitiesTest, ThresholdsNest) {
  std::int64_t before = phantom->labels.geometry.voxelCount() + 1;
  for (const double threshold : {0.02, 0.3, 0.6, 0.9}) {
    const Segment s = segmentOf({2}, {threshold, 0, false, 0});
    for (std::size_t v = 0; v < s.mask.size(); ++v)
      ASSERT_EQ(s.mask[v] != 0, s.probability[v] >= static_cast<float>(threshold));
    EXPECT_LE(s.voxels, before);
    EXPECT_GT(s.voxels, 0);
    before = s.voxels;
  }
}

TEST_F(ClassProbabilitiesTest, PartsAndSmoothing) {
  const std::int64_t first = segmentOf({1}).voxels, third = segmentOf({3}).voxels;
  ASSERT_NE(first, third);
  // Liver and left kidney share no face, so they stay separate parts.
  const Segment both = segmentOf({1, 3});
  ASSERT_EQ(both.voxels, first + third);
  const Segment large = segmentOf({1, 3}, {0, 0, false, 8.0 * static_cast<double>(std::max(first, third))});
  const Segment largest = segmentOf({1, 3}, {0, 0, true, 0});
  EXPECT_EQ(onGrid(largest), onGrid(large));
  EXPECT_EQ(segmentOf({1, 3}, {0, 0, true, 1e9}).voxels, 0);
  // A box loses its corners and keeps its middle.
  const auto sharp = onGrid(segmentOf({2})), smooth = onGrid(segmentOf({2}, {0, 2, false, 0}));
  int lost = 0, gained = 0;
  for (std::size_t v = 0; v < sharp.size(); ++v) {
    lost += sharp[v] && !smooth[v];
    gained += !sharp[v] && smooth[v];
  }
  EXPECT_GE(lost, 8);
  EXPECT_LT(4 * lost, segmentOf({2}).voxels);
  EXPECT_EQ(gained, 0);
}

TEST_F(ClassProbabilitiesTest, SameAtAnyNumberOfThreads) {
  const auto one = encoded(phantom->labels.geometry, 1), many = encoded(phantom->labels.geometry, 5);
  for (int c = 1; c < 4; ++c) {
    const std::vector<int> classes{c};
    EXPECT_EQ(one.voxels(c), many.voxels(c));
    EXPECT_EQ(one.segment(classes).probability, many.segment(classes).probability);
  }
  EXPECT_EQ(one.bytes(), many.bytes());
}

TEST_F(ClassProbabilitiesTest, BadInputIsRefused) {
  const auto p = encoded(phantom->labels.geometry);
  const std::vector<int> liver{1}, background{0}, beyond{4};
  EXPECT_THROW(p.segment(background), Error);
  EXPECT_THROW(p.segment(beyond), Error);
  EXPECT_THROW(p.segment(liver, {1.5, 0, false, 0}), Error);
  EXPECT_THROW(p.segment(liver, {NAN, 0, false, 0}), Error);
  EXPECT_THROW(p.segment(liver, {0, -1, false, 0}), Error);
  EXPECT_THROW(p.segment(liver, {0, 0, false, -1}), Error);
  std::stop_source stop;
  stop.request_stop();
  FeatureQueryOptions stopped;
  stopped.stop = stop.get_token();
  EXPECT_THROW(ClassProbabilities(phantom->field, *model, phantom->labels.geometry, stopped), Error);
}

} // namespace
} // namespace innergs::testing
