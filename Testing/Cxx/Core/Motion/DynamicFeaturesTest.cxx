#include "Core/Motion/DynamicFeatures.h"
#include "Core/Features/FeatureTraining.h"
#include "Core/Motion/DynamicJob.h"
#include "MovingPhantom.h"

#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

class DynamicFeatures : public ::testing::TestWithParam<DynamicKind> {};

TEST_P(DynamicFeatures, LabelsFollowTheTissueToTimesThatWereNotSeen) {
  const TimeSeries all = movingPhantom(evenTimes(13));
  const std::vector<std::int64_t> heldOut{3, 6, 9};
  std::vector<std::int64_t> kept;
  for (std::int64_t f = 0; f < all.size(); ++f)
    if (std::find(heldOut.begin(), heldOut.end(), f) == heldOut.end()) kept.push_back(f);
  Settings settings;
  settings.kind = GetParam();
  const DynamicResult fit = DynamicJob(framesOf(all, kept), settings).run();
  ASSERT_TRUE(fit.field);
  const DynamicField& field = *fit.field;
  const double learned = all.times[1]; // not the canonical field's own
  const Labelmap given = movingLabels(all.geometry, learned);
  const FeatureModel model =
      trainFeatures(featureFieldAt(field, learned), given, {{1, "left"}, {2, "right"}});
  ASSERT_EQ(model.classes(), 3);
  for (const std::int64_t f : heldOut) {
    const double time = all.times[static_cast<std::size_t>(f)];
    const ClassImage image =
        classify(featureFieldAt(field, time), model, all.geometry, queryAt(field, time, learned));
    Labelmap found{all.geometry, {}, {}};
    for (const std::uint16_t c : image.classes)
      found.voxels.push_back(model.labels[c]);
    const Labelmap truth = movingLabels(all.geometry, time);
    for (const std::uint16_t label : {std::uint16_t{1}, std::uint16_t{2}}) {
      RecordProperty("dice", std::to_string(dice(found, truth, label)));
      EXPECT_GT(dice(found, truth, label), 0.9) << "time " << time << " label " << label;
      EXPECT_GT(dice(found, truth, label), dice(given, truth, label)) << "time " << time;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, DynamicFeatures, ::testing::Values(DynamicKind::Motion, DynamicKind::Network));

} // namespace
} // namespace innergs::testing
