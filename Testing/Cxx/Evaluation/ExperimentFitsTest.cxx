#include "Core/Base/NumberText.h"
#include "Core/Base/SystemMemory.h"
#include "Evaluation/ExperimentAblation.h"
#include "Evaluation/ExperimentStatic.h"

#include "../Core/TestVolumes.h"
#include "../Core/ThrownError.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

using namespace innergs;
using namespace innergs::testing;

namespace {

ExperimentSetup quickSetup() {
  ExperimentSetup setup;
  setup.volume = phantom(grid(24, 22, 20));
  setup.volumeName = "phantom";
  setup.quick = true;
  setup.gaussians = 400;
  setup.settings.threads = 2;
  setup.settings.device = "cpu";
  return setup;
}

std::size_t column(const ExperimentTable& table, const std::string& name) {
  const auto at = std::find(table.columns.begin(), table.columns.end(), name);
  EXPECT_NE(at, table.columns.end()) << name;
  return static_cast<std::size_t>(at - table.columns.begin());
}

/// Rows without their timings.
std::vector<std::vector<std::string>> figures(const ExperimentTable& table) {
  std::vector<std::vector<std::string>> rows = table.rows;
  for (const char* name : {"seconds", "ms_iteration", "render_ms"})
    for (auto& row : rows)
      row[column(table, name)].clear();
  return rows;
}

bool mentions(const ExperimentTable& table, const std::string& words) {
  return std::any_of(table.notes.begin(), table.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

} // namespace

TEST(ExperimentFits, ThatTablesShareRunOnce) {
  ExperimentSetup setup = quickSetup();
  std::vector<std::string> said;
  setup.say = [&](const std::string& line) { said.push_back(line); };
  ExperimentFits fits(setup);
  const Ablation blending = runAblation(fits, "blending");
  EXPECT_EQ(said.size(), blending.rows.size());
  EXPECT_EQ(said.size(), std::set<std::string>(said.begin(), said.end()).size());
  const Ablation initialisation = runAblation(fits, "initialisation");
  EXPECT_EQ(said.size(), blending.rows.size() + initialisation.rows.size() - 2);
  EXPECT_EQ(blending.rows[0].fit, initialisation.rows[0].fit); // normalised, adaptive
  EXPECT_EQ(blending.rows[2].fit, initialisation.rows[2].fit); // alpha, adaptive
  runAblation(fits, "blending");
  EXPECT_EQ(said.size(), blending.rows.size() + initialisation.rows.size() - 2);
}

TEST(ExperimentFits, OfOneSeedGiveTheSameFigures) {
  const auto table = [](std::uint64_t seed) {
    ExperimentSetup setup = quickSetup();
    setup.settings.seed = seed;
    ExperimentFits fits(setup);
    return figures(runAblation(fits, "initialisation").table);
  };
  const auto first = table(1);
  EXPECT_EQ(table(1), first);
  EXPECT_NE(table(2), first);
}

TEST(ExperimentFits, DensificationHappensEvenInAQuickOne) {
  ExperimentFits fits(quickSetup());
  const Ablation ablation = runAblation(fits, "densification");
  const ExperimentTable& table = ablation.table;
  const auto count = [&](const std::vector<std::string>& row, const char* name) {
    return std::stoll(row[column(table, name)]);
  };
  int densified = 0;
  for (const auto& row : table.rows) {
    const bool paper = row[0].find("paper's") != std::string::npos;
    const std::int64_t grown = count(row, "split") + count(row, "cloned");
    EXPECT_EQ(paper, grown > 0) << row[0];
    if (paper)
      EXPECT_NE(count(row, "gaussians"), 200) << row[0]; // half of 400 at the start
    else
      EXPECT_EQ(grown + count(row, "pruned"), 0) << row[0];
    densified += paper;
  }
  EXPECT_EQ(densified, 3);
}

TEST(ExperimentFits, SelectionIsTheOnlyDifferenceWithinAGroup) {
  ExperimentFits fits(quickSetup());
  const Ablation ablation = runAblation(fits, "selection");
  const ExperimentTable& table = ablation.table;
  ASSERT_EQ(table.rows.size(), 9u);
  const std::size_t psnr = column(table, "psnr_db");
  const auto value = [&](std::size_t row) { return leadingNumber(table.rows[row][psnr]).value(); };
  // At 2.2 sigma all three cover every pixel; the fits differ only by rounding.
  EXPECT_NEAR(value(1), value(0), 0.5) << table.rows[1][0];
  EXPECT_NEAR(value(2), value(0), 0.5) << table.rows[2][0];
  EXPECT_NE(table.rows[3], table.rows[0]); // 3 sigma gives another fit
  EXPECT_GT(std::abs(value(3) - value(0)), 0.01);
  for (const auto& row : table.rows)
    EXPECT_GT(leadingNumber(row[column(table, "render_ms")]).value(), 0) << row[0];
}

TEST(ExperimentFits, OptimisersAreVaried) {
  ExperimentFits fits(quickSetup());
  const Ablation ablation = runAblation(fits, "optimiser");
  std::set<const FitOutcome*> different;
  int adam = 0;
  for (const auto& row : ablation.rows) {
    different.insert(row.fit);
    adam += row.label.rfind("Adam", 0) == 0;
  }
  EXPECT_EQ(different.size(), ablation.rows.size());
  EXPECT_EQ(adam, 3);
}

TEST(ExperimentFits, OfOtherCountsSayThatThePapersAreNoComparison) {
  ExperimentSetup setup = quickSetup();
  setup.papersVolume = true;
  ExperimentTable table;
  setup.gaussians = kPaperGaussians;
  notePapersFigures(setup, table);
  EXPECT_TRUE(table.notes.empty());
  setup.gaussians = 5000;
  notePapersFigures(setup, table);
  EXPECT_TRUE(mentions(table, "not for 5000"));
  EXPECT_FALSE(mentions(table, "145x174x145"));
  setup.papersVolume = false;
  notePapersFigures(setup, table);
  EXPECT_TRUE(mentions(table, "145x174x145"));
}

TEST(ExperimentFits, BeyondTheMemoryAreRefused) {
  if (availableMemory() == 0) GTEST_SKIP() << "this system does not say how much memory is available";
  ExperimentSetup setup = quickSetup();
  setup.quick = false;
  setup.gaussians = 1'000'000'000;
  ExperimentFits fits(setup);
  for (const char* name : {"selection", "blending"})
    EXPECT_EQ(test::codeOf([&] { runAblation(fits, name); }), ErrorCode::Memory) << name;
}
