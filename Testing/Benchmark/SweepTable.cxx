#include "Markdown.h"
#include "Scores.h"
#include "Tables.h"

#include <algorithm>
#include <cmath>

namespace innergs::bench {
namespace {

constexpr double kTolerance = 0.02; // dB

/// Gain over the best of linear, cubic, Lanczos and back-projection.
double gainOf(const nlohmann::json& report, const char* key) {
  const Scores s(report);
  return s.get("gaussians", key) - s.best({"linear", "cubic", "lanczos", "backprojection"}, key);
}

struct Group {
  int cases = 0, below = 0;
  double sum = 0, worst = INFINITY, worstSsim = INFINITY;
  std::string worstCase, missing;

  void add(const HeldOutOutcome& outcome) {
    if (!outcome.outcome.json) {
      missing = outcome.outcome.missing;
      return;
    }
    const double gain = gainOf(*outcome.outcome.json, "psnr");
    if (!std::isfinite(gain)) return;
    ++cases;
    sum += gain;
    below += gain < -kTolerance;
    worstSsim = std::min(worstSsim, gainOf(*outcome.outcome.json, "ssim"));
    if (gain < worst) {
      worst = gain;
      worstCase = outcome.volume + ", " + outcome.heldOutCase;
    }
  }
};

void addRow(MarkdownTable& table, const std::string& name, const Group& g) {
  if (g.cases == 0) {
    table.add({name, g.missing});
    return;
  }
  table.add({name, std::to_string(g.cases), withSign(g.sum / g.cases, 2), std::to_string(g.below),
             withSign(g.worst, 2), g.worstCase, withSign(g.worstSsim, 4)});
}

} // namespace

std::string sweepTable(const std::vector<HeldOutOutcome>& outcomes) {
  MarkdownTable table({"volume", "cases", "mean over the best interpolation", "below it by more than 0.02 dB",
                       "worst", "where", "worst SSIM over the best"});
  Group all;
  std::string name;
  Group group;
  for (const HeldOutOutcome& outcome : outcomes) {
    if (outcome.volume != name) {
      if (!name.empty()) addRow(table, name, group);
      name = outcome.volume;
      group = {};
    }
    group.add(outcome);
    all.add(outcome);
  }
  if (!name.empty()) addRow(table, name, group);
  addRow(table, "**all**", all);
  return table.text();
}

} // namespace innergs::bench
