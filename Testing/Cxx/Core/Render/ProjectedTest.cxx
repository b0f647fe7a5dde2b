#include "Core/Render/Projected.h"
#include "Core/Fit/Initialise.h"
#include "Core/Render/Rows.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

// Oblique grids of few planes, with and without a profile: Gaussians that are only marked have no row in
// any plane, and all others are unchanged.
TEST(Projected, NearOnesAreTheSameAndTheRestReachNoPlane) {
  ThreadPool pool(2);
  Cloud cloud;
  cloud.low = {-20, -20, -20};
  cloud.high = {20, 20, 20};
  cloud.anisotropy = 6;
  GaussianField field = randomField(2000, cloud, 5, Blending::Normalised, true);
  field.gaussians = inMortonOrder(std::move(field.gaussians));
  field.gaussians[7].mean[1] = std::nanf("");
  GaussianBlocks blocks;
  blocks.measure(field, pool);
  std::vector<float> values(2000, 0.5f);
  for (const bool blurred : {false, true})
    for (const std::vector<double>& planes :
         {std::vector<double>{0}, std::vector<double>{-1, 0, 0.5}, std::vector<double>{100}}) {
      SampleGrid grid;
      grid.nx = grid.ny = 9;
      grid.z = planes;
      grid.indexToModel.linear = obliqueDirection(0.4) * diagonal({1, 0.8, 3});
      grid.indexToModel.offset = {-4, 2, 5};
      ClosedFormPsf psf;
      if (blurred) {
        psf.active = true;
        const float covariance[6] = {1.f, 0.1f, 0.2f, 2.f, -0.3f, 4.f};
        std::copy_n(covariance, 6, psf.covariance);
      }
      std::vector<Projected> all;
      NearGaussians near;
      project(field, values, grid, psf, pool, all);
      projectNear(field, values, grid, psf, pool, near);
      ASSERT_EQ(near.number.size(), near.projected.size());
      EXPECT_TRUE(std::is_sorted(near.number.begin(), near.number.end()));
      const GridView view{grid.nx, grid.ny, static_cast<int>(planes.size()), grid.stride(), grid.z.data()};
      int missed = 0, reaching = 0;
      std::size_t n = 0;
      for (std::size_t i = 0; i < all.size(); ++i) {
        int first, last;
        planeRange(all[i], view, first, last);
        if (n < near.number.size() && near.number[n] == i) {
          EXPECT_EQ(std::memcmp(&near.projected[n++], &all[i], sizeof(Projected)), 0);
          reaching += first < last;
          continue;
        }
        ++missed;
        EXPECT_GE(first, last) << "it reaches a plane";
      }
      EXPECT_EQ(n, near.number.size());
      EXPECT_GT(missed, 500);
      NearGaussians same;
      projectNear(field, values, grid, psf, pool, same, &blocks);
      EXPECT_EQ(same.number, near.number);
      EXPECT_TRUE(std::equal(same.projected.begin(), same.projected.end(), near.projected.begin(),
                             near.projected.end(), [](const Projected& a, const Projected& b) {
                               return std::memcmp(&a, &b, sizeof(Projected)) == 0;
                             }));
      EXPECT_EQ(reaching > 100, planes.front() < 100);
    }
}

TEST(GaussianBlocks, HoldTheirGaussians) {
  ThreadPool pool(2);
  Cloud cloud;
  cloud.low = {-20, -20, -20};
  cloud.high = {20, 20, 20};
  GaussianField field = randomField(1000, cloud, 5, Blending::Normalised, true);
  field.gaussians = inMortonOrder(std::move(field.gaussians));
  field.gaussians[70].logScale[2] = std::nanf("");
  GaussianBlocks blocks;
  blocks.measure(field, pool);
  ASSERT_EQ(blocks.all().size(), 16U);
  double volumes = 0;
  for (std::size_t i = 0; i < field.gaussians.size(); ++i) {
    const GaussianBlocks::Block& block = blocks.all()[i / GaussianBlocks::kSize];
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(block.low[a], field.gaussians[i].mean[a]);
      EXPECT_GE(block.high[a], field.gaussians[i].mean[a]);
      const double scale = i == 70 ? 0 : std::exp(field.gaussians[i].logScale[a]);
      EXPECT_GE(block.scale, scale * (1 - 1e-6));
    }
  }
  for (std::size_t b = 0; b < blocks.all().size(); ++b) {
    const Vec3 edges = blocks.all()[b].high - blocks.all()[b].low;
    EXPECT_EQ(std::isinf(edges[0]), b == 1);
    if (b != 1) volumes += edges[0] * edges[1] * edges[2];
  }
  EXPECT_LT(volumes / 15, 0.2 * 40 * 40 * 40);
}

} // namespace
} // namespace innergs::testing
