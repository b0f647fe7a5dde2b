#include "Evaluation/LabelInterpolation.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Evaluation/ExperimentSegmentation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace innergs {
namespace {

/// A cone along K, label 1, with a core of label 2; every `step`-th slice labelled.
Labelmap cone(int step = 1) {
  Labelmap labels;
  labels.geometry.size = {24, 24, 13};
  for (int k = 0; k < 13; ++k) {
    labels.labelled.push_back(k % step == 0);
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) {
        const double r = std::hypot(i - 11.5, j - 11.5);
        labels.voxels.push_back(k % step != 0 ? 0 : r < 2.2 ? 2 : r < 3.2 + 0.6 * k ? 1 : 0);
      }
  }
  return labels;
}

TEST(LabelInterpolation, ShapesLieBetweenTheirNeighbours) {
  const Labelmap truth = cone(), teacher = cone(6);
  std::vector<std::uint8_t> judged;
  for (const auto labelled : teacher.labelled)
    judged.push_back(!labelled);
  const LabelAgreement shape = agreement(shapeBasedInterpolation(teacher), truth, judged);
  const LabelAgreement nearest = agreement(nearestLabelledSlice(teacher), truth, judged);
  EXPECT_GT(shape.dice(1), 0.94); // a quarter of a pixel around a radius of 5
  EXPECT_EQ(shape.dice(2), 1);
  EXPECT_LT(nearest.dice(1), 0.93);
  EXPECT_GT(nearest.dice(1), 0.7);
  const Labelmap filled = shapeBasedInterpolation(teacher);
  for (std::size_t v = 0; v < filled.voxels.size(); ++v)
    if (teacher.isLabelled(static_cast<std::int64_t>(v / 576))) {
      EXPECT_EQ(filled.voxels[v], truth.voxels[v]);
    }
}

TEST(LabelInterpolation, AgreementCounts) {
  Labelmap a, b;
  a.geometry.size = b.geometry.size = {4, 1, 1};
  a.voxels = {1, 1, 0, 2};
  b.voxels = {1, 0, 0, 1};
  const LabelAgreement same = agreement(a, b);
  EXPECT_DOUBLE_EQ(same.dice(1), 0.5);
  EXPECT_DOUBLE_EQ(same.iou(1), 1.0 / 3);
  EXPECT_DOUBLE_EQ(same.pixelAccuracy, 0.5);
  EXPECT_EQ(same.dice(2), 0);
  b.geometry.size = {2, 2, 1};
  EXPECT_THROW(agreement(a, b), Error);
  Labelmap none = cone();
  std::fill(none.labelled.begin(), none.labelled.end(), 0);
  EXPECT_THROW(nearestLabelledSlice(none), Error);
}

TEST(ExperimentSegmentation, ComparesWithTheSlicesLeftOut) {
  SegmentationExperiment e;
  const Labelmap truth = cone();
  e.volume.geometry = truth.geometry;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v) // with texture: intensities alone decide nothing
    e.volume.voxels.push_back(100.f + 100.f * static_cast<float>(truth.voxels[v]) +
                              30.f * std::sin(static_cast<float>(v % 977)));
  e.volumeName = "cone";
  e.sets = {{"labels", truth, {{1, "mantle"}, {2, "core"}}}};
  e.sets[0].labels.labelled.clear();
  e.every = {1, 4};
  e.leastVoxels = 50;
  e.settings.iterations = 20;
  const SegmentationResult result = runSegmentation(e);
  ASSERT_EQ(result.methods.rows.size(), 7u); // three with all slices, four with every 4th
  const auto dice = [&](int row) { return wholeTextNumber(result.methods.rows[row][4]).value(); };
  EXPECT_EQ(dice(0), 1);       // the labels themselves, with the residual
  EXPECT_EQ(dice(1), 1);       // the teacher itself, on its own slices
  EXPECT_GT(dice(2), 0.85);    // without the residual
  EXPECT_GT(dice(3), dice(6)); // than the nearest slice
  EXPECT_EQ(dice(4), 0);       // the teacher elsewhere
  EXPECT_GE(wholeTextNumber(result.methods.rows[3][7]).value(), dice(3)); // its five best slices
  EXPECT_EQ(result.methods.rows[3].back(), "slices not labelled");
  EXPECT_EQ(result.classes.rows.size(), 4u);
  ASSERT_EQ(result.grids.rows.size(), 14u); // two grids of five rows, four of every second voxel
  const auto gridDice = [&](int row) { return wholeTextNumber(result.grids.rows[row][4]).value(); };
  for (int row = 0; row < 14; ++row)
    if (result.grids.rows[row][2] == "Gaussians") {
      EXPECT_GT(gridDice(row), 0.7) << row;
    }
  EXPECT_GE(gridDice(10), gridDice(11)); // with the residual as without
  EXPECT_GT(gridDice(10), gridDice(13)); // than the nearest label
  e.sets[0].labels.geometry.spacing[0] = 2;
  EXPECT_THROW(runSegmentation(e), Error);
}

} // namespace
} // namespace innergs
