#include "Core/Features/FeatureDecoder.h"
#include "RandomFields.h"

#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

constexpr int N = 16;

struct Case {
  FeatureModel model;
  std::vector<float> latent;
  float rank = 0.3f;
  std::vector<std::uint16_t> classes{0, 2, 3};
  std::vector<float> target{0.2f, 0.7f, 0.1f};

  Case() {
    Numbers random(9);
    const auto fill = [&](std::vector<float>& v, std::size_t size) {
      for (std::size_t n = 0; n < size; ++n)
        v.push_back(static_cast<float>(random(-1, 1)));
    };
    model.names = {"background", "a", "b", "c"};
    fill(model.codes, 4 * FeatureModel::kTerms * N);
    fill(latent, N);
  }
  double loss() const {
    float p[3];
    decode<N>(model, latent.data(), rank, classes, p);
    double sum = 0;
    for (int n = 0; n < 3; ++n)
      sum -= static_cast<double>(target[n]) * std::log(static_cast<double>(p[n]));
    return sum;
  }
  /// Central difference with respect to any number that the loss depends on.
  double slope(float& x) {
    const float before = x, h = 1e-2f;
    x = before + h;
    const double above = loss();
    x = before - h;
    const double below = loss();
    x = before;
    return (above - below) / (2 * static_cast<double>(h));
  }
};

TEST(FeatureGradient, LatentAndCodesMatchFiniteDifferences) {
  Case c;
  float residual[3], gradient[N] = {};
  std::vector<float> codes(c.model.codes.size(), 0.f);
  decode<N>(c.model, c.latent.data(), c.rank, c.classes, residual);
  for (int n = 0; n < 3; ++n)
    residual[n] -= c.target[n];
  decodeBackward<N>(c.model, c.latent.data(), c.rank, c.classes, residual, gradient, codes.data());
  for (int n = 0; n < N; ++n)
    EXPECT_NEAR(gradient[n], c.slope(c.latent[static_cast<std::size_t>(n)]), 2e-3);
  for (std::size_t n = 0; n < codes.size(); ++n)
    EXPECT_NEAR(codes[n], c.slope(c.model.codes[n]), 2e-3) << n;
}

TEST(FeatureGradient, ProbabilitiesSumToOne) {
  Case c;
  for (float& x : c.latent)
    x *= 300; // logits far beyond the range of exp()
  float p[3];
  decode<N>(c.model, c.latent.data(), c.rank, c.classes, p);
  EXPECT_NEAR(p[0] + p[1] + p[2], 1, 1e-5);
}

} // namespace
} // namespace innergs::testing
