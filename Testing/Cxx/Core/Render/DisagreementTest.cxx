#include "Core/Render/Disagreement.h"

#include "Core/Base/Error.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A direct implementation: every Gaussian at every centre, in double precision.
std::vector<double> bruteForce(const GaussianField& field) {
  std::vector<double> result;
  for (const Gaussian& at : field.gaussians) {
    double w = 0, n = 0, s = 0;
    for (const Gaussian& g : field.gaussians) {
      double q[4], length = 0;
      for (int a = 0; a < 4; ++a)
        length += double(g.quaternion[a]) * g.quaternion[a];
      for (int a = 0; a < 4; ++a)
        q[a] = g.quaternion[a] / std::sqrt(length);
      const Mat3 r{{{{1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
                      2 * (q[1] * q[3] + q[0] * q[2])},
                     {2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[1] * q[1] + q[3] * q[3]),
                      2 * (q[2] * q[3] - q[0] * q[1])},
                     {2 * (q[1] * q[3] - q[0] * q[2]), 2 * (q[2] * q[3] + q[0] * q[1]),
                      1 - 2 * (q[1] * q[1] + q[2] * q[2])}}}};
      const Vec3 d{double(at.mean[0]) - g.mean[0], double(at.mean[1]) - g.mean[1],
                   double(at.mean[2]) - g.mean[2]};
      const Vec3 local = transpose(r) * d;
      double distance = 0;
      for (int a = 0; a < 3; ++a)
        distance += std::pow(local[a] * std::exp(-double(g.logScale[a])), 2);
      const double cut = field.cutoff * field.cutoff;
      if (distance >= cut) continue;
      const double p = std::exp(double(g.logWeight)) * (std::exp(-0.5 * distance) - std::exp(-0.5 * cut));
      const double value = g.intensity + g.slope[0] * d[0] + g.slope[1] * d[1] + g.slope[2] * d[2];
      w += p, n += p * value, s += p * value * value;
    }
    result.push_back(field.intensityScale * std::sqrt(std::max(0.0, s / w - n * n / (w * w))));
  }
  return result;
}

} // namespace

TEST(Disagreement, IsItsDefinition) {
  GaussianField field = randomField(400, {}, 8);
  field.gaussians[7].logScale[0] = 3; // one that reaches everything
  field.intensityScale = 90;
  field.intensityOffset = 1000;
  field.modelToWorld = {obliqueDirection(0.4), {10, 20, 30}};
  const auto expected = bruteForce(field);
  for (const int threads : {1, 2}) {
    const auto values = disagreement(field, threads);
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(values[i], expected[i], 2e-3) << i;
  }
}

TEST(Disagreement, IsNothingWhereAllAgreeOrOneIsAlone) {
  GaussianField field = randomField(200, {}, 8, Blending::Normalised, false);
  for (Gaussian& g : field.gaussians)
    g.intensity = 0.5f;
  for (const float v : disagreement(field))
    EXPECT_NEAR(v, 0, 1e-4);
  field.gaussians.resize(1);
  EXPECT_EQ(disagreement(field), std::vector<float>{0.f});
  field.gaussians.clear();
  EXPECT_TRUE(disagreement(field).empty());
}

TEST(Disagreement, NeedsValuesThatAreAveraged) {
  EXPECT_THROW(disagreement(randomField(5, {}, 8, Blending::Additive, false)), Error);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(disagreement(randomField(5, {}, 8), 1, stop.get_token()), Error);
}
