#include "Core/Prediction/CandidateWeights.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

namespace innergs {
namespace {

constexpr int kFine = 8; // samples of a signal per slice distance

/// A first-order autoregressive process, blurred by sigma slice distances.
std::vector<double> blurredWalk(int slices, double sigma) {
  std::mt19937 engine(7);
  const int margin = 6 * kFine;
  std::vector<double> walk(static_cast<std::size_t>(slices) * kFine + 2 * margin);
  double now = 0;
  for (double& v : walk)
    v = now = 0.975 * now + static_cast<double>(engine() % 2001) / 1000 - 1;
  std::vector<double> signal(static_cast<std::size_t>(slices - 1) * kFine + 1);
  for (std::size_t n = 0; n < signal.size(); ++n) {
    double weights = 0;
    for (int t = -margin; t <= margin; ++t) {
      const double x = t / (kFine * std::max(sigma, 1e-3)), w = std::exp(-0.5 * x * x);
      signal[n] += w * walk[n + margin + t];
      weights += w;
    }
    signal[n] /= weights;
  }
  return signal;
}

double decibelsOf(const SliceWeights& weights, const std::vector<double>& slices,
                  const std::vector<double>& signal) {
  double error = 0, power = 0;
  for (std::size_t n = 0; n < signal.size(); ++n) {
    double value = 0;
    for (std::size_t t = 0; t < weights.weight[n].size(); ++t)
      value += weights.weight[n][t] * slices[weights.first[n] + t];
    error += (value - signal[n]) * (value - signal[n]);
    power += signal[n] * signal[n];
  }
  return 10 * std::log10(power / error);
}

std::vector<double> everySample(int slices) {
  std::vector<double> at;
  for (int n = 0; n <= (slices - 1) * kFine; ++n)
    at.push_back(static_cast<double>(n) / kFine);
  return at;
}

TEST(Kriging, BeatsLanczosOnWhatIsAsSmoothAsItExpects) {
  constexpr int slices = 200;
  for (const double sigma : {0.5, 1.0}) {
    const std::vector<double> signal = blurredWalk(slices, sigma);
    std::vector<double> seen;
    for (std::size_t n = 0; n < signal.size(); n += kFine)
      seen.push_back(signal[n]);
    const auto of = [&](Candidate c, double blur) {
      return decibelsOf(
          candidateWeights(c, Kriging(blur, SliceProfile::Point, 0), slices, everySample(slices)), seen,
          signal);
    };
    EXPECT_GT(of(Candidate::Kriging, sigma), of(Candidate::Lanczos, 0) + (sigma < 1 ? 0.2 : 4)) << sigma;
    EXPECT_GT(of(Candidate::Kriging, sigma), of(Candidate::Kriging, 0.5 * sigma)) << sigma;
    EXPECT_GT(of(Candidate::Kriging, 0.7 * sigma), of(Candidate::Cubic, 0)) << "a blur that is known roughly";
  }
}

TEST(Kriging, IsNearlyLinearWithoutBlur) {
  const std::vector<double> at{3.25, 3.5, 7.9};
  const SliceWeights kriging =
      candidateWeights(Candidate::Kriging, Kriging(0, SliceProfile::Point, 0), 12, at);
  for (std::size_t z = 0; z < at.size(); ++z) {
    std::vector<double> row(12);
    for (std::size_t t = 0; t < kriging.weight[z].size(); ++t)
      row[kriging.first[z] + t] = kriging.weight[z][t];
    const double fraction = at[z] - std::floor(at[z]);
    const auto base = static_cast<std::size_t>(at[z]);
    EXPECT_NEAR(row[base], 1 - fraction, 0.02);
    EXPECT_NEAR(row[base + 1], fraction, 0.02);
  }
}

TEST(Kriging, SeesThroughThickSlices) {
  constexpr int slices = 120;
  const std::vector<double> signal = blurredWalk(slices, 0.4);
  for (const SliceProfile profile : {SliceProfile::Box, SliceProfile::Gaussian}) {
    std::vector<double> seen;
    for (int s = 0; s < slices; ++s) {
      double sum = 0, weights = 0;
      for (int t = -2 * kFine; t <= 2 * kFine; ++t) {
        const double x = static_cast<double>(t) / kFine;
        const double w = profile == SliceProfile::Box
                             ? (std::abs(t) == kFine / 2 ? 0.5 : std::abs(t) < kFine / 2)
                             : std::exp2(-4 * x * x);
        const int n = std::clamp(s * kFine + t, 0, static_cast<int>(signal.size()) - 1);
        sum += w * signal[n];
        weights += w;
      }
      seen.push_back(sum / weights);
    }
    const auto of = [&](Candidate c) {
      return decibelsOf(candidateWeights(c, Kriging(0.4, profile, 1), slices, everySample(slices)), seen,
                        signal);
    };
    EXPECT_GT(of(Candidate::Kriging), of(Candidate::Cubic) + 2);
    EXPECT_GT(of(Candidate::Kriging), of(Candidate::Lanczos) + 1.5);
  }
}

TEST(Kriging, AddsUpToOneFromAnyNumberOfSlices) {
  for (const std::int64_t slices : {1, 2, 3, 23, 24, 25, 300})
    for (const double blur : {0.0, 0.3, 1.0, 2.0}) {
      const std::vector<double> at{0, 0.4, 0.5 * static_cast<double>(slices - 1),
                                   static_cast<double>(slices)};
      const SliceWeights w =
          candidateWeights(Candidate::Kriging, Kriging(blur, SliceProfile::Box, 1), slices, at);
      for (const auto& row : w.weight)
        EXPECT_NEAR(std::accumulate(row.begin(), row.end(), 0.0), 1, 1e-5) << slices << " " << blur;
    }
}

} // namespace
} // namespace innergs
