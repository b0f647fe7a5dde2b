#include "Core/Render/Kernels.h"
#include "RandomFields.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

/// The limits of planes, rows and columns, for Gaussians from a tenth of a voxel to larger than the grid.
class Limits : public ::testing::TestWithParam<double> {};

TEST_P(Limits, NeverMissAVoxelInsideTheEllipsoid) {
  SampleGrid samples;
  const GridGeometry geometry = grid(26, 21, 19, {0.8, 1.1, 1.7}, {4, -3, 8}, obliqueDirection(0.9, true));
  samples.indexToModel = Affine3{obliqueDirection(-0.3), {1, 2, 3}} * geometry.indexToWorld();
  samples.nx = 26;
  samples.ny = 21;
  for (int k = 0; k < 19; ++k)
    samples.z.push_back(k + 0.2 * std::sin(3.0 * k)); // uneven, like quadrature planes
  const GridView view{26, 21, 19, samples.stride(), samples.z.data()};
  Cloud cloud;
  const Vec3 centre = samples.indexToModel({12.5, 10, 9});
  for (int a = 0; a < 3; ++a)
    cloud.low[a] = centre[a] - 18, cloud.high[a] = centre[a] + 18;
  cloud.minSigma = 0.1;
  cloud.maxSigma = 12;
  cloud.anisotropy = GetParam();
  GaussianField field = randomField(250, cloud, 7);
  field.cutoff = 2.7;
  ThreadPool pool(2);
  std::vector<Projected> projected;
  project(field, {}, samples, {}, pool, projected);
  const auto parameters = parametersOf(field);
  const double r2 = field.cutoff * field.cutoff;
  std::int64_t inside = 0, visited = 0;
  for (std::size_t n = 0; n < projected.size(); ++n) {
    const ReferenceGaussian reference(parameters[n], field.blending, field.cutoff);
    const Projected& g = projected[n];
    int k0, k1, c0, c1;
    planeRange(g, view, k0, k1);
    columnRange(g, c0, c1);
    for (int k = 0; k < view.nz; ++k) {
      int r0 = 0, r1 = 0;
      const bool rows = k >= k0 && k < k1 && rowRange(g, planeOffset(g, samples.z[k]), r0, r1);
      for (int y = 0; y < view.ny; ++y) {
        const bool row = rows && y >= g.cell[1] + r0 && y < g.cell[1] + r1;
        visited += row;
        double nearest = 1e300;
        for (int x = 0; x < view.nx; ++x) {
          const double m = reference.mahalanobis(samples.indexToModel({double(x), double(y), samples.z[k]}));
          nearest = std::min(nearest, m);
          if (m > r2 * (1 - 1e-4)) continue;
          ++inside;
          ASSERT_TRUE(row) << "Gaussian " << n << " misses row " << y << " of plane " << k;
          ASSERT_GE(x, g.cell[0] + c0);
          ASSERT_LT(x, g.cell[0] + c1);
        }
        if (!row) continue;
        // Exact: the row's line touches the ellipsoid (x need not be a whole column).
        const Vec3 a = samples.indexToModel({0, double(y), samples.z[k]});
        const Vec3 b = samples.indexToModel({1, double(y), samples.z[k]});
        const double m0 = reference.mahalanobis(a), m1 = reference.mahalanobis(b);
        const double m2 = reference.mahalanobis(a + 2.0 * (b - a));
        const double curvature = 0.5 * (m2 - 2 * m1 + m0), slope = m1 - m0 - curvature;
        ASSERT_LE(m0 - slope * slope / (4 * curvature), r2 * (1 + 1e-3))
            << "Gaussian " << n << " visits row " << y << " of plane " << k << " for nothing";
      }
    }
  }
  EXPECT_GT(inside, 20000);
  EXPECT_GT(visited, 5000);
}

INSTANTIATE_TEST_SUITE_P(Anisotropy, Limits, ::testing::Values(1.0, 4.0, 12.0));
