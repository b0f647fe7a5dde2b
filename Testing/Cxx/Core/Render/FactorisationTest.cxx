#include "Core/Render/Kernels.h"
#include "RandomFields.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A random covariance in slice coordinates, with axes between 0.3 and 9.
void randomCovariance(Numbers& random, double* s6) {
  double q[4], r[9], scaled[9];
  for (double& x : q)
    x = random(-1, 1);
  math::rotation(q, r);
  for (int k = 0; k < 3; ++k) {
    const double scale = std::exp(random(std::log(0.3), std::log(9.0)));
    for (int i = 0; i < 3; ++i)
      scaled[3 * i + k] = r[3 * i + k] * scale;
  }
  math::outer(scaled, s6);
}

double quadratic(const double* s, const double* d) {
  return s[0] * d[0] * d[0] + s[3] * d[1] * d[1] + s[5] * d[2] * d[2] +
         2 * (s[1] * d[0] * d[1] + s[2] * d[0] * d[2] + s[4] * d[1] * d[2]);
}

} // namespace

TEST(Factorisation, SliceConditionalTimesMarginalIsTheGaussian) {
  Numbers random(1);
  double largest = 0;
  for (int n = 0; n < 2000; ++n) {
    double covariance[6], precision[6];
    randomCovariance(random, covariance);
    math::invertSymmetric(covariance, precision);
    const auto c = math::sliceConditional(covariance);
    const double determinant = c.covariance[0] * c.covariance[2] - c.covariance[1] * c.covariance[1];
    ASSERT_GT(determinant, 0);
    double d[3];
    for (int a : {0, 1, 2})
      d[a] = random(-1, 1) * std::sqrt(covariance[a == 0 ? 0 : a == 1 ? 3 : 5]);
    const double joint = std::exp(-0.5 * quadratic(precision, d));
    const double u = d[0] - c.shift[0] * d[2], v = d[1] - c.shift[1] * d[2];
    const double conditional =
        std::exp(-0.5 * (c.covariance[2] * u * u - 2 * c.covariance[1] * u * v + c.covariance[0] * v * v) /
                 determinant);
    const double marginal = std::exp(-0.5 * d[2] * d[2] / c.variance);
    ASSERT_NEAR(conditional * marginal, joint, 1e-6);
    largest = std::max(largest, joint);
  }
  EXPECT_GT(largest, 0.5); // some points are inside the Gaussians
}

TEST(Factorisation, RowFormIsThePrecisionsQuadraticForm) {
  Numbers random(2);
  for (int n = 0; n < 2000; ++n) {
    double covariance[6], precision[6];
    randomCovariance(random, covariance);
    math::invertSymmetric(covariance, precision);
    const auto f = math::rowForm(precision);
    const double d[3] = {random(-9, 9), random(-9, 9), random(-9, 9)};
    const double x = d[0] + f.l1 * d[1] + f.l2 * d[2], y = d[1] + f.l3 * d[2];
    const double expected = quadratic(precision, d);
    ASSERT_NEAR(f.pxx * x * x + f.b * y * y + d[2] * d[2] / covariance[5], expected, 1e-9 * (1 + expected));
  }
}

TEST(Factorisation, InverseAndRotationAreExact) {
  Numbers random(3);
  for (int n = 0; n < 200; ++n) {
    double s[6], p[6], q[4], r[9];
    randomCovariance(random, s);
    const double det = math::invertSymmetric(s, p);
    EXPECT_GT(det, 0);
    const double full[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
    const double inverse[9] = {p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5]};
    double product[9], gram[9], t[9];
    math::multiply(full, inverse, product);
    for (double& x : q)
      x = random(-3, 3);
    math::rotation(q, r);
    math::transposed(r, t);
    math::multiply(t, r, gram);
    for (int i = 0; i < 9; ++i) {
      EXPECT_NEAR(product[i], i % 4 == 0, 1e-9);
      EXPECT_NEAR(gram[i], i % 4 == 0, 1e-12);
    }
  }
}

/// The limits of planes, rows and columns, for Gaussians from a tenth of a voxel to larger than the lattice.
class Limits : public ::testing::TestWithParam<double> {};

TEST_P(Limits, NeverMissAVoxelInsideTheEllipsoid) {
  Lattice lattice;
  const GridGeometry geometry = grid(26, 21, 19, {0.8, 1.1, 1.7}, {4, -3, 8}, obliqueDirection(0.9, true));
  lattice.indexToModel = Affine3{obliqueDirection(-0.3), {1, 2, 3}} * geometry.indexToWorld();
  lattice.nx = 26;
  lattice.ny = 21;
  for (int k = 0; k < 19; ++k)
    lattice.z.push_back(k + 0.2 * std::sin(3.0 * k)); // uneven, like quadrature planes
  const LatticeView view{26, 21, 19, lattice.stride(), lattice.z.data()};
  Cloud cloud;
  const Vec3 centre = lattice.indexToModel({12.5, 10, 9});
  for (int a = 0; a < 3; ++a)
    cloud.low[a] = centre[a] - 18, cloud.high[a] = centre[a] + 18;
  cloud.minSigma = 0.1;
  cloud.maxSigma = 12;
  cloud.anisotropy = GetParam();
  GaussianField field = randomField(250, cloud, 7);
  field.cutoff = 2.7;
  ThreadPool pool(2);
  std::vector<Projected> projected;
  project(field, {}, lattice, {}, pool, projected);
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
      const bool rows = k >= k0 && k < k1 && rowRange(g, planeOffset(g, lattice.z[k]), r0, r1);
      for (int y = 0; y < view.ny; ++y) {
        const bool row = rows && y >= g.cell[1] + r0 && y < g.cell[1] + r1;
        visited += row;
        double nearest = 1e300;
        for (int x = 0; x < view.nx; ++x) {
          const double m = reference.mahalanobis(lattice.indexToModel({double(x), double(y), lattice.z[k]}));
          nearest = std::min(nearest, m);
          if (m > r2 * (1 - 1e-4)) continue;
          ++inside;
          ASSERT_TRUE(row) << "Gaussian " << n << " misses row " << y << " of plane " << k;
          ASSERT_GE(x, g.cell[0] + c0);
          ASSERT_LT(x, g.cell[0] + c1);
        }
        if (!row) continue;
        // Exact: the row's line touches the ellipsoid (x need not be a whole column).
        const Vec3 a = lattice.indexToModel({0, double(y), lattice.z[k]});
        const Vec3 b = lattice.indexToModel({1, double(y), lattice.z[k]});
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
