#include "Core/Base/Error.h"
#include "Core/Features/IntensityScale.h"
#include "Core/Features/LabelCompletion.h"
#include "Features/BoxPhantom.h"

#include <gtest/gtest.h>

#include <numeric>

namespace innergs::testing {
namespace {

TEST(Labelmap, KnowsLabelsFromAScan) {
  Volume volume{BoxPhantom(4).labels.geometry, std::vector<float>(64, 3)};
  EXPECT_EQ(labelmapOf(volume).voxels[5], 3);
  for (const float value : {0.5f, -1.f, 65536.f, NAN}) {
    volume.voxels[7] = value;
    EXPECT_THROW(labelmapOf(volume), Error);
  }
}

TEST(Labelmap, FindsTheAxisOfSparseSlices) {
  const BoxPhantom phantom;
  Labelmap given = phantom.every(4);
  given.labelled.clear(); // as read from a file
  Labelmap sparse = withSparseSlices(given);
  EXPECT_EQ(sparse.geometry, given.geometry);
  EXPECT_TRUE(sparse.isLabelled(4) && sparse.isLabelled(8) && !sparse.isLabelled(5));
  // The same along I: that axis becomes K, and each voxel keeps its position.
  Labelmap along{given.geometry, std::vector<std::uint16_t>(given.voxels.size(), 0), {}};
  for (std::size_t v = 0; v < along.voxels.size(); ++v)
    if (v % 14 % 4 == 0) along.voxels[v] = phantom.labels.voxels[v];
  sparse = withSparseSlices(along);
  EXPECT_TRUE(sparse.isLabelled(4) && !sparse.isLabelled(5));
  EXPECT_EQ(resampled(sparse, along.geometry).voxels, along.voxels);
  EXPECT_TRUE(withSparseSlices(phantom.labels).labelled.empty());
}

TEST(LabelCompletion, KeepsLabelsAndSumsToOne) {
  const BoxPhantom phantom;
  std::vector<float> ranks;
  for (const auto label : phantom.labels.voxels)
    ranks.push_back(0.25f * static_cast<float>(label));
  ThreadPool pool(2);
  const Labelmap teacher = phantom.every(4);
  const auto soft = completeLabels(teacher, 4, ranks, pool);
  for (std::size_t v = 0; v < soft.size(); ++v) {
    EXPECT_NEAR(std::accumulate(soft[v].shares.begin(), soft[v].shares.end(), 0.f), 1, 0.02f);
    if (teacher.isLabelled(static_cast<std::int64_t>(v / (14 * 14)))) {
      EXPECT_EQ(soft[v].classes[0], phantom.labels.voxels[v]);
      EXPECT_EQ(soft[v].shares[0], 1);
    }
  }
}

TEST(IntensityScale, RanksWhatLiesAboveTheBackground) {
  std::vector<float> voxels(100, -1000.f);
  for (int n = 0; n < 300; ++n)
    voxels.push_back(static_cast<float>(n));
  const IntensityScale scale = intensityScaleOf(voxels);
  EXPECT_NEAR(scale(0), 0, 1e-5);
  EXPECT_NEAR(scale(149.5f), 0.5, 0.01);
  EXPECT_NEAR(scale(299), 1, 1e-5);
  EXPECT_EQ(scale(5000), 1);
  EXPECT_NEAR(scale(-1000), -0.7, 1e-5);
  EXPECT_NEAR(scale(-500), -0.5, 1e-5);
  EXPECT_LT(scale(NAN), 0);
  EXPECT_EQ(IntensityScale{}(7), 0);
  EXPECT_TRUE(std::isfinite(intensityScaleOf(std::vector<float>(50, 3.f))(3)));
}

} // namespace
} // namespace innergs::testing
