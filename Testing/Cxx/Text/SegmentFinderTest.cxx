#include "Text/SegmentFinder.h"
#include "Core/Base/Error.h"
#include "Core/Features/FeatureTraining.h"
#include "Features/BoxPhantom.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace innergs {
namespace {

using testing::BoxPhantom;

SegmentFinder finderOf(const BoxPhantom& phantom) {
  return SegmentFinder(
      {std::make_shared<const GaussianField>(phantom.field),
       std::make_shared<const FeatureModel>(trainFeatures(
           phantom.field, phantom.labels, {{1, "liver"}, {2, "kidney_left"}, {3, "kidney_right"}})),
       {}});
}

TEST(SegmentFinder, AQueryMakesOneSegmentOrOneEach) {
  const BoxPhantom phantom;
  SegmentFinder finder = finderOf(phantom);
  const auto requested = [&](const char* query) { return finder.requested(query, finder.find(query)); };
  const auto liver = requested("hepar");
  ASSERT_EQ(liver.size(), 1u);
  EXPECT_EQ(liver[0].terms.name, "liver");
  EXPECT_EQ(liver[0].terms.code, "10200004");
  EXPECT_EQ(liver[0].classes, std::vector<int>{1});
  const auto open = requested("kidney"); // whichever side: both, never one of them alone
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0].terms.side, Side::Left);
  EXPECT_NE(terminologyEntry(open[0].terms).find("^Anatomical Structure~SCT^64033007^"), std::string::npos);
  EXPECT_NE(terminologyEntry(open[0].terms).find("~SCT^7771000^Left~"), std::string::npos);
  EXPECT_EQ(terminologyEntry({"Tumor 2", "", "", Side::None, {}}), "");
  EXPECT_EQ(open[1].terms.name, "kidney_right");
  EXPECT_NE(open[0].terms.color, open[1].terms.color);
  const auto both = requested("both kidneys");
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both[0].terms.name, "both kidneys");
  EXPECT_EQ(both[0].classes, (std::vector<int>{2, 3}));
  EXPECT_TRUE(requested("spleen").empty());
  EXPECT_TRUE(requested("bicycle").empty());
}

TEST(SegmentFinder, KnowsWhatAGridDoesNotShow) {
  const BoxPhantom phantom;
  SegmentFinder finder = finderOf(phantom);
  EXPECT_EQ(finder.probabilities(), nullptr);
  finder.encode(cropped(phantom.labels.geometry, {0, 0, 0}, {5, 5, 14})); // a corner, the liver alone
  EXPECT_EQ(finder.find("liver").kind, AnswerKind::Found);
  EXPECT_EQ(finder.find("left kidney").kind, AnswerKind::NotInVolume);
  finder.encode(phantom.labels.geometry);
  EXPECT_EQ(finder.find("left kidney").kind, AnswerKind::Found);
  const auto wanted = finder.requested("liver", finder.find("liver"));
  const Segment liver = finder.probabilities()->segment(wanted.at(0).classes);
  EXPECT_EQ(liver.voxels, std::count(phantom.labels.voxels.begin(), phantom.labels.voxels.end(), 1));
  const ClassProbabilities* before = finder.probabilities();
  finder.encode(phantom.labels.geometry);
  EXPECT_EQ(finder.probabilities(), before);
}

TEST(SegmentFinder, NeedsFeatures) {
  EXPECT_THROW(SegmentFinder({std::make_shared<const GaussianField>(), nullptr, {}}), Error);
}

} // namespace
} // namespace innergs
