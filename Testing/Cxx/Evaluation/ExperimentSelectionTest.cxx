#include "Evaluation/ExperimentSelection.h"

#include "../Core/RandomFields.h"
#include "../Core/ThrownError.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// The selections by their definitions, directly from a Gaussian's parameters, without the engine.
class Definition {
public:
  explicit Definition(const Gaussian& g) {
    double w = g.quaternion[0], x = g.quaternion[1], y = g.quaternion[2], z = g.quaternion[3];
    const double n = std::sqrt(w * w + x * x + y * y + z * z);
    w /= n, x /= n, y /= n, z /= n;
    const Mat3 r{{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                   {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                   {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}}};
    Vec3 variance;
    for (int a = 0; a < 3; ++a) {
      mean_[a] = g.mean[a];
      variance[a] = std::exp(2.0 * static_cast<double>(g.logScale[a]));
      longest_ = std::max(longest_, std::sqrt(variance[a]));
    }
    sigma_ = r * diagonal(variance) * transpose(r);
    precision_ = inverse(sigma_);
  }

  bool contributes(const Vec3& x, double threshold) const {
    const Vec3 d = x - mean_;
    return std::exp(-0.5 * dot(d, precision_ * d)) >= threshold;
  }

  bool candidate(const Vec3& x, Selection selection) const {
    const Vec3 d = x - mean_;
    if (selection == Selection::Method1) {
      for (int a = 0; a < 3; ++a)
        if (std::abs(d[a]) > 3 * longest_) return false;
      return true;
    }
    const double tt = sigma_[2][2];
    if (std::abs(d[2]) > 3 * std::sqrt(tt)) return false;
    const double uu = sigma_[0][0] - sigma_[0][2] * sigma_[0][2] / tt,
                 uv = sigma_[0][1] - sigma_[0][2] * sigma_[1][2] / tt,
                 vv = sigma_[1][1] - sigma_[1][2] * sigma_[1][2] / tt;
    const double lambda = 0.5 * (uu + vv) + std::hypot(0.5 * (uu - vv), uv);
    const double half = 3 * std::sqrt(lambda) * std::sqrt(std::exp(-0.5 * d[2] * d[2] / tt));
    return std::abs(d[0] - sigma_[0][2] / tt * d[2]) <= half &&
           std::abs(d[1] - sigma_[1][2] / tt * d[2]) <= half;
  }

private:
  Vec3 mean_;
  Mat3 sigma_, precision_;
  double longest_ = 0;
};

SelectionCounts bruteForce(const GaussianField& cloud, int size, double threshold, Selection selection) {
  SelectionCounts counts;
  for (const Gaussian& g : cloud.gaussians) {
    const Definition definition(g);
    for (int k = 0; k < size; ++k)
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
          const Vec3 x{double(i), double(j), double(k)};
          const bool contributes = definition.contributes(x, threshold);
          const bool candidate =
              selection == Selection::Exact ? contributes : definition.candidate(x, selection);
          counts.contributing += contributes;
          counts.candidates += candidate;
          counts.falsePositives += candidate && !contributes;
          counts.falseNegatives += contributes && !candidate;
        }
  }
  return counts;
}

GaussianField randomCloud(std::uint64_t seed, double threshold) {
  Cloud cloud;
  cloud.low = {-2, -2, -2}; // some reach beyond the cube, some start outside
  cloud.high = {22, 22, 22};
  cloud.anisotropy = 12;
  cloud.maxLogWeight = 0;
  GaussianField field = randomField(40, cloud, seed, Blending::Normalised, false);
  field.cutoff = std::sqrt(-2 * std::log(threshold)) * (1 + 1e-5);
  return field;
}

// Single precision may decide either way for pixels exactly on a box's edge, and Method 1's box is slightly
// larger.
constexpr double kEdge = 4;

} // namespace

TEST(ExperimentSelection, CountsAreThoseOfTheDefinitions) {
  SelectionSimulation simulation;
  for (const double threshold : {0.01, 0.05})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      simulation.threshold = threshold;
      const GaussianField cloud = randomCloud(seed, threshold);
      for (const Selection selection : {Selection::Method1, Selection::Method2}) {
        const SelectionCounts ours = countCandidates(cloud, simulation, selection);
        const SelectionCounts truth = bruteForce(cloud, simulation.size, threshold, selection);
        SCOPED_TRACE(std::string(selectionName(selection)) + ", seed " + std::to_string(seed));
        ASSERT_GT(truth.contributing, 1000);
        EXPECT_NEAR(double(ours.contributing), double(truth.contributing), kEdge);
        EXPECT_NEAR(double(ours.candidates), double(truth.candidates), kEdge);
        EXPECT_NEAR(double(ours.falsePositives), double(truth.falsePositives), kEdge);
        EXPECT_NEAR(double(ours.falseNegatives), double(truth.falseNegatives), kEdge);
        EXPECT_EQ(ours.candidates - ours.falsePositives, ours.contributing - ours.falseNegatives);
      }
    }
}

TEST(ExperimentSelection, ExactMissesNothingAndVisitsLittleElse) {
  SelectionSimulation simulation;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SelectionCounts counts =
        countCandidates(randomCloud(seed, simulation.threshold), simulation, Selection::Exact);
    EXPECT_EQ(counts.falseNegatives, 0) << seed;
    EXPECT_LE(double(counts.falsePositives), 0.01 * double(counts.contributing)) << seed;
  }
}

TEST(ExperimentSelection, ReproducesThePapersSimulation) {
  SelectionSimulation simulation;
  simulation.clouds = 60;
  simulation.repetitions = 3;
  const auto scores = simulateSelections(simulation);
  ASSERT_EQ(scores.size(), 3u);
  const double pixels = 8000.0 * simulation.clouds;
  const auto perPixel = [&](std::int64_t count) { return double(count) / pixels; };
  const SelectionCounts &method1 = scores[0].counts, &method2 = scores[1].counts, &exact = scores[2].counts;
  EXPECT_NEAR(method1.area / double(method1.slices), 209.80, 0.05);
  EXPECT_NEAR(perPixel(method1.falsePositives), 15.79, 0.8);
  EXPECT_LT(perPixel(method1.falseNegatives), 1e-3);
  EXPECT_NEAR(perPixel(method1.candidates), 16.70, 0.8);
  EXPECT_NEAR(perPixel(method2.falsePositives), 1.82, 0.2);
  EXPECT_NEAR(perPixel(method2.falseNegatives), 0.126, 0.02);
  EXPECT_NEAR(perPixel(method2.candidates), 2.62, 0.25);
  EXPECT_EQ(exact.falseNegatives, 0);
  EXPECT_LE(perPixel(exact.candidates), 1.6);
  EXPECT_LE(double(exact.candidates), 1.01 * double(exact.contributing));
  EXPECT_GT(double(method2.candidates), 2 * double(method2.contributing));
  EXPECT_EQ(method1.contributing, exact.contributing);
  for (const SelectionScore& score : scores) {
    EXPECT_GT(score.seconds, 0);
    EXPECT_GT(score.scalarSeconds, 0);
  }
}

TEST(ExperimentSelection, SaysWhichIsFaster) {
  SelectionSimulation simulation;
  const SelectionScore scores[] = {{Selection::Method1, {}, 9e-6, 40e-6},
                                   {Selection::Method2, {}, 3e-6, 8e-6},
                                   {Selection::Exact, {}, 6e-6, 2e-6}};
  const std::string text = textOf(selectionTable(simulation, scores));
  EXPECT_NE(text.find("Exact is 2.00 times SLOWER than Method 2 with the SIMD kernels and 4.00 times faster"),
            std::string::npos)
      << text;
}

TEST(ExperimentSelection, TableShowsThePapersFigures) {
  SelectionSimulation simulation;
  simulation.clouds = 2;
  simulation.repetitions = 1;
  const ExperimentTable table = selectionTable(simulation, simulateSelections(simulation));
  ASSERT_EQ(table.rows.size(), 3u);
  const std::string csv = csvOf(table), text = textOf(table);
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "selection,box_area,paper_area,false_positives,paper_false_positives,false_negatives,"
            "paper_false_negatives,candidates,paper_candidates,per_contributing,microseconds,scalar_"
            "microseconds,measured_on");
  for (const char* figure : {"209.80", "15.79", "16.70", "63.09", "1.82", "0.126", "2.62"})
    EXPECT_NE(text.find(figure), std::string::npos) << figure;
  EXPECT_NE(text.find("does not give its covariances"), std::string::npos);
  EXPECT_NE(text.find("Nothing is held out"), std::string::npos);
}

TEST(ExperimentSelection, RefusesSimulationsOfNothing) {
  const auto refused = [](auto change) {
    SelectionSimulation simulation;
    change(simulation);
    EXPECT_THROW(simulateSelections(simulation), Error);
  };
  refused([](auto& s) { s.gaussians = 0; });
  refused([](auto& s) { s.clouds = 0; });
  refused([](auto& s) { s.size = 0; });
  refused([](auto& s) { s.threshold = 0; });
  refused([](auto& s) { s.threshold = -0.01; });
  refused([](auto& s) { s.threshold = 1; });
  refused([](auto& s) { s.sigma[1] = 0; });
  const double infinite = std::numeric_limits<double>::infinity();
  refused([&](auto& s) { s.high = infinite; });
  refused([&](auto& s) { s.low = -infinite; });
  refused([&](auto& s) { s.low = s.high = infinite; });
  refused([](auto& s) { s.high = std::nan(""); });
}

TEST(ExperimentSelection, Stops) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(test::codeOf([&] { simulateSelections({}, "", stop.get_token()); }), ErrorCode::Cancelled);
}
