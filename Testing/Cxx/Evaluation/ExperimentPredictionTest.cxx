#include "Evaluation/ExperimentPrediction.h"
#include "Core/Base/NumberText.h"
#include "Evaluation/HeldOutProtocol.h"

#include "../Core/TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

ExperimentSetup quickSetup() {
  ExperimentSetup setup;
  setup.volume = phantom(grid(44, 40, 45));
  setup.volumeName = "phantom";
  setup.quick = true;
  setup.settings.threads = 2;
  setup.settings.device = "cpu";
  return setup;
}

const PredictionAblation::Row& rowOf(const PredictionAblation::Case& c, const std::string& label) {
  const auto found =
      std::find_if(c.rows.begin(), c.rows.end(), [&](const auto& row) { return row.label == label; });
  if (found == c.rows.end()) throw std::runtime_error("there is no row " + label);
  return *found;
}

void expectTheScoresOfAnEvaluation(const PredictionAblation& ablation) {
  const ExperimentSetup setup = quickSetup();
  EvaluationOptions options;
  options.settings = setup.settings;
  options.settings.preset = Preset::Fast;
  for (const auto& [kind, c] : {std::pair{HeldOutCase::Kind::KeepEvery, &ablation.cases[0]},
                                std::pair{HeldOutCase::Kind::Thick, &ablation.cases[1]}}) {
    const EvaluationReport report = evaluateHeldOut(setup.volume, {kind, 4, 2, 0}, options);
    for (const MethodScore& method : report.methods) {
      const std::string label = method.name == "gaussians"        ? "everything"
                                : method.name == "lanczos"        ? "Lanczos"
                                : method.name == "backprojection" ? "back-projection"
                                                                  : method.name;
      const auto& row = rowOf(*c, label);
      ASSERT_TRUE(row.quality) << label;
      EXPECT_EQ(row.quality->psnr, method.psnr) << label;
      EXPECT_EQ(row.quality->ssim, method.ssim) << label;
    }
  }
}

void expectPartsThatDiffer(const PredictionAblation& ablation) {
  for (const PredictionAblation::Case& c : ablation.cases) {
    for (const PredictionAblation::Row& row : c.rows) {
      ASSERT_TRUE(row.quality) << c.title << ", " << row.label;
      EXPECT_GT(row.quality->psnr, 10) << c.title << ", " << row.label;
    }
    for (const auto& [one, other] : {std::pair{"network alone", "linear filter alone"},
                                     std::pair{"network alone", "network alone, from random weights"},
                                     std::pair{"everything", "mixture of interpolations alone"},
                                     std::pair{"everything", "everything but the field"}})
      EXPECT_NE(rowOf(c, one).quality->psnr, rowOf(c, other).quality->psnr) << c.title << ", " << one;
  }
  const PredictionAblation::Case& gapped = ablation.cases[0];
  EXPECT_NE(rowOf(gapped, "everything").quality->psnr,
            rowOf(gapped, "everything but learning").quality->psnr);
}

void expectGainsOverTheBestInterpolation(const PredictionAblation& ablation) {
  const ExperimentTable& table = ablation.table;
  for (const PredictionAblation::Case& c : ablation.cases) {
    double best = -1e9;
    for (const auto& row : table.rows)
      if (row[0] == c.title && row[2] == "interpolation")
        best = std::max(best, leadingNumber(row[4]).value());
    EXPECT_EQ(best, 0) << c.title;
  }
  EXPECT_EQ(table.rows.size(), ablation.cases[0].rows.size() + ablation.cases[1].rows.size());
}

TEST(ExperimentPrediction, ScoresAndVariesTheParts) {
  const PredictionAblation ablation = runPredictionAblation(quickSetup());
  ASSERT_EQ(ablation.cases.size(), 2u);
  expectTheScoresOfAnEvaluation(ablation);
  expectPartsThatDiffer(ablation);
  expectGainsOverTheBestInterpolation(ablation);
}

TEST(ExperimentPrediction, LeavesCellsOfPartsThatDoNotApplyEmpty) {
  ExperimentSetup setup = quickSetup();
  setup.volume = phantom(grid(20, 18, 41)); // too few pixels to learn from
  const PredictionAblation ablation = runPredictionAblation(setup);
  EXPECT_FALSE(rowOf(ablation.cases[0], "network alone").quality);
  EXPECT_TRUE(rowOf(ablation.cases[0], "everything").quality);
  for (const auto& row : ablation.table.rows)
    EXPECT_EQ(row[3].empty(), row[1].find("alone") != std::string::npos &&
                                  (row[1].find("network") == 0 || row[1].find("filter") != std::string::npos))
        << row[1];
}

} // namespace
} // namespace innergs::testing
