#include "Core/Model/GaussianMath.h"
#include "RandomFields.h"

#include <algorithm>
#include <cmath>
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
