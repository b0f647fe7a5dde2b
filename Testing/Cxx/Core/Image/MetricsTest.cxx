#include "Core/Image/Metrics.h"

#include "Core/Base/Error.h"
#include "Core/Image/Ssim.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

// A direct implementation of Wang et al.: an 11×11 window per pixel, two passes, reflected borders.
double naiveSsim(const std::vector<float>& a, const std::vector<float>& b, int width, int height, int x,
                 int y, double range) {
  const auto reflect = [](int i, int n) {
    while (i < 0 || i >= n)
      i = i < 0 ? -i - 1 : 2 * n - 1 - i;
    return i;
  };
  double weights = 0, meanA = 0, meanB = 0, varianceA = 0, varianceB = 0, covariance = 0;
  const auto each = [&](auto&& visit) {
    for (int dy = -5; dy <= 5; ++dy)
      for (int dx = -5; dx <= 5; ++dx) {
        const int p = reflect(x + dx, width) + width * reflect(y + dy, height);
        visit(std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5)), double(a[p]), double(b[p]));
      }
  };
  each([&](double w, double va, double vb) { weights += w, meanA += w * va, meanB += w * vb; });
  meanA /= weights, meanB /= weights;
  each([&](double w, double va, double vb) {
    varianceA += w * (va - meanA) * (va - meanA);
    varianceB += w * (vb - meanB) * (vb - meanB);
    covariance += w * (va - meanA) * (vb - meanB);
  });
  varianceA /= weights, varianceB /= weights, covariance /= weights;
  const double c1 = std::pow(0.01 * range, 2), c2 = std::pow(0.03 * range, 2);
  return (2 * meanA * meanB + c1) * (2 * covariance + c2) /
         ((meanA * meanA + meanB * meanB + c1) * (varianceA + varianceB + c2));
}

} // namespace

TEST(Metrics, SsimMapAgreesWithTheDefinition) {
  for (const auto& [width, height] : {std::pair{23, 17}, std::pair{7, 4}, std::pair{1, 9}}) {
    for (const double offset : {0.0, -1000.0}) {
      const auto truth = randomVolume(grid(width, height, 1), offset, offset + 200, 3).voxels;
      auto image = truth;
      const auto noise = randomVolume(grid(width, height, 1), -40, 40, 4).voxels;
      for (std::size_t p = 0; p < image.size(); ++p)
        image[p] += noise[p];
      const auto map = ssimMap(image, truth, width, height, 200);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          ASSERT_NEAR(map[x + width * y], naiveSsim(image, truth, width, height, x, y, 200), 1e-5)
              << x << " " << y;
    }
  }
}

TEST(Metrics, SsimOfEqualImagesIsOne) {
  const auto truth = randomVolume(grid(20, 20, 1), 0, 1).voxels;
  for (float s : ssimMap(truth, truth, 20, 20, 1))
    ASSERT_FLOAT_EQ(s, 1);
}

TEST(Metrics, PsnrOfAKnownError) {
  const std::vector<float> truth(100, 50), image(100, 53);
  EXPECT_NEAR(pooledPsnr(image, truth, {}, 255), 20 * std::log10(255.0 / 3), 1e-9);
  EXPECT_TRUE(std::isinf(pooledPsnr(truth, truth, {}, 255)));
}

TEST(Metrics, PsnrCountsTheMaskAndKnownTruthOnly) {
  std::vector<float> truth(100, 50), image(100, 52);
  std::vector<std::uint8_t> mask(100, 1);
  for (int p = 0; p < 50; ++p)
    mask[p] = 0, image[p] = 1e6f;
  truth[60] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(pooledPsnr(image, truth, mask, 100), 20 * std::log10(50.0), 1e-9);
  EXPECT_THROW(pooledPsnr(image, truth, std::vector<std::uint8_t>(99, 1), 100), Error);
}

TEST(Metrics, SliceQualityTakesTheSliceOfTheAxis) {
  const Volume truth = randomVolume(grid(12, 14, 16), 0, 100);
  for (int axis = 0; axis < 3; ++axis) {
    Volume image = truth;
    const std::int64_t stride[3] = {1, 12, 12 * 14};
    for (std::size_t p = 0; p < image.voxels.size(); ++p)
      if (static_cast<std::int64_t>(p) / stride[axis] % truth.geometry.size[axis] == 5) image.voxels[p] += 10;
    const Quality q = sliceQuality(image, truth, axis, 5, 100);
    EXPECT_NEAR(q.psnr, 20, 1e-3);
    EXPECT_EQ(q.voxels, 12 * 14 * 16 / truth.geometry.size[axis]);
    EXPECT_LT(q.ssim, 1);
    EXPECT_TRUE(std::isinf(sliceQuality(image, truth, axis, 4, 100).psnr));
  }
  EXPECT_THROW(sliceQuality(truth, truth, 2, 16, 100), Error);
}

TEST(Metrics, PooledQualityRestrictsToMaskAndSlices) {
  const Volume truth = randomVolume(grid(12, 14, 6), 0, 100);
  Volume image = truth;
  std::vector<std::uint8_t> mask(truth.voxels.size(), 0);
  for (std::int64_t k = 0; k < 6; ++k)
    for (std::int64_t p = 0; p < 12 * 14; ++p) {
      const auto at = static_cast<std::size_t>(p + 12 * 14 * k);
      mask[at] = p % 2;
      image.voxels[at] += p % 2 == 0 ? 1e4f
                          : k == 3   ? 5.0f
                                     : 77.0f; // only odd voxels of slice 3 have the error 5
    }
  const Quality q = pooledQuality(image, truth, mask, 100, std::vector<std::int64_t>{3});
  EXPECT_NEAR(q.psnr, 20 * std::log10(20.0), 1e-3);
  EXPECT_EQ(q.voxels, 12 * 14 / 2);
}

TEST(Metrics, PooledQualityAveragesTheSsimMap) {
  const Volume truth = randomVolume(grid(15, 13, 2), 0, 100, 5),
               image = randomVolume(grid(15, 13, 2), 0, 100, 6);
  double sum = 0;
  for (int k = 0; k < 2; ++k) {
    const std::vector<float> a(image.voxels.begin() + 195 * k, image.voxels.begin() + 195 * (k + 1));
    const std::vector<float> b(truth.voxels.begin() + 195 * k, truth.voxels.begin() + 195 * (k + 1));
    for (int y = 0; y < 13; ++y)
      for (int x = 0; x < 15; ++x)
        sum += naiveSsim(a, b, 15, 13, x, y, 100);
  }
  EXPECT_NEAR(pooledQuality(image, truth, {}, 100).ssim, sum / 390, 1e-5);
}

TEST(Metrics, DifferentSizesAreRefused) {
  EXPECT_THROW(pooledQuality(randomVolume(grid(3, 4, 5), 0, 1), randomVolume(grid(4, 3, 5), 0, 1), {}, 1),
               Error);
}
