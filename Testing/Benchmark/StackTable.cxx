#include "Markdown.h"
#include "Scores.h"
#include "Tables.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace innergs::bench {
namespace {

/// What a measured value must not fall below or exceed.
struct Bounds {
  double low = -INFINITY, high = INFINITY;

  std::string text(int digits) const {
    const std::string least = fixed(low, digits), most = fixed(high, digits);
    if (std::isfinite(low) && std::isfinite(high)) return least + " to " + most;
    return std::isfinite(low) ? "≥ " + least : std::isfinite(high) ? "≤ " + most : "";
  }
  double distance(double value) const { return std::min(value - low, high - value); }
};

Bounds atLeast(double low) {
  return {low, INFINITY};
}
Bounds atMost(double high) {
  return {-INFINITY, high};
}

/// From the scores of a case and those of the still stacks of the same seed; NaN: not measured.
using Measure = std::function<double(const Scores& own, const Scores& still)>;

Measure of(const char* key, double factor = 1) {
  return [=](const Scores& own, const Scores&) { return factor * own.get("gaussians", key); };
}

Measure over(const char* method) {
  return [=](const Scores& own, const Scores&) { return own.psnr("gaussians") - own.psnr(method); };
}

double belowStill(const Scores& own, const Scores& still) {
  return still.psnr("gaussians") - own.psnr("gaussians");
}

/// The uncertainty takes a second fit.
Measure ofOneFit(const char* key, double factor = 1) {
  return [=](const Scores& own, const Scores&) {
    return std::isnan(own.get("gaussians", "uncertainty/coverage_90")) ? factor * own.get("gaussians", key)
                                                                       : NAN;
  };
}

struct Quantity {
  std::string name, unit;
  int digits;
  Bounds target;
  Measure measure;
};

std::vector<Quantity> quantitiesOf(const std::string& volume, const std::string& stacksCase) {
  const bool much = stacksCase == kMovedMuch, moved = stacksCase == kMoved || much;
  std::vector<Quantity> all{{"PSNR", "dB", 2, {}, of("psnr")}};
  if (stacksCase == kMoved && volume == "ICBM152") all[0].target = atLeast(30.5);
  const auto add = [&](Quantity quantity) { all.push_back(std::move(quantity)); };
  if (stacksCase == kStill || stacksCase == kTwoStill) {
    add({"over the average", "dB", 2, atLeast(stacksCase == kStill ? 3 : 2.5), over("average")});
    add({"over back-projection", "dB", 2, atLeast(0.5), over("backprojection")});
  }
  if (stacksCase == kMoved) add({"below still", "dB", 2, atMost(1.5), belowStill});
  if (stacksCase == kShaded) add({"below unshaded", "dB", 2, atMost(1), belowStill});
  add({"over the fit without correction", "dB", 2,
       stacksCase == kShaded || stacksCase == kMoved ? Bounds{} : atLeast(much ? 0 : -0.1),
       over("uncorrected")});
  if (moved) {
    add({"median pose error", "mm", 2, much ? Bounds{} : atMost(0.4), of("pose_errors/mm/median")});
    add({"median pose error", "°", 2, much ? Bounds{} : atMost(0.4), of("pose_errors/degrees/median")});
    add({"90th percentile of it", "mm", 2, much ? Bounds{} : atMost(1), of("pose_errors/mm/percentile_90")});
    add({"90th percentile of it", "°", 2, much ? Bounds{} : atMost(1),
         of("pose_errors/degrees/percentile_90")});
  }
  if (stacksCase == kShaded) {
    add({"shading left between the stacks", "%", 1, {}, of("bias_errors/between", 100)});
    add({"shading left in all", "%", 1, {}, of("bias_errors/shared", 100)});
  } else {
    add({"drift", "mm", 2, moved ? Bounds{} : atMost(0.05), of("pose_errors/common_mm")});
    add({"drift", "°", 2, {}, of("pose_errors/common_degrees")});
  }
  if (stacksCase == kStill || stacksCase == kMoved) {
    add({"time", "s", 0, atMost(moved ? 240 : 90), ofOneFit("seconds")});
    add({"CPU time", "s", 0, {}, ofOneFit("cpu_seconds")});
    add({"peak memory", "GB", 2, atMost(moved ? 1.5 : 1), ofOneFit("peak_memory_bytes", 1e-9)});
  }
  if (stacksCase != kTwoStill && !much)
    add({"held by 90 % intervals", "%", 1, {85, 95}, of("uncertainty/coverage_90", 100)});
  return all;
}

const StackOutcome* find(const std::vector<StackOutcome>& outcomes, const StackOutcome& like,
                         const std::string& stacksCase) {
  const auto found = std::find_if(outcomes.begin(), outcomes.end(), [&](const StackOutcome& o) {
    return o.volume == like.volume && o.stacksCase == stacksCase && o.seed == like.seed && o.outcome.json;
  });
  return found == outcomes.end() ? nullptr : &*found;
}

/// Its values for all seeds of a case; empty: it was not measured.
std::vector<double> valuesOf(const Quantity& quantity, const std::vector<StackOutcome>& outcomes,
                             const StackOutcome& like) {
  static const nlohmann::json nothing{{"methods", nlohmann::json::object()}};
  std::vector<double> values;
  for (const StackOutcome& o : outcomes) {
    if (o.volume != like.volume || o.stacksCase != like.stacksCase || !o.outcome.json) continue;
    const StackOutcome* still = find(outcomes, o, kStill);
    const double value =
        quantity.measure(Scores(*o.outcome.json), Scores(still ? *still->outcome.json : nothing));
    if (!std::isnan(value)) values.push_back(value);
  }
  return values;
}

} // namespace

std::string stackTable(const std::vector<StackOutcome>& outcomes) {
  MarkdownTable table({"volume", "case", "quantity", "target", "measured", "met"});
  std::set<std::pair<std::string, std::string>> done;
  for (const StackOutcome& o : outcomes) {
    if (!o.outcome.json)
      table.add({o.volume, o.stacksCase.empty() ? "all" : o.stacksCase, o.outcome.missing});
    if (!done.emplace(o.volume, o.stacksCase).second) continue;
    for (const Quantity& quantity : quantitiesOf(o.volume, o.stacksCase)) {
      std::string measured;
      double distance = INFINITY;
      for (const double value : valuesOf(quantity, outcomes, o)) {
        measured += (measured.empty() ? "" : ", ") + fixed(value, quantity.digits);
        distance = std::min(distance, quantity.target.distance(value));
      }
      if (measured.empty()) continue;
      const std::string target = quantity.target.text(quantity.digits);
      table.add({o.volume, o.stacksCase, quantity.name + ", " + quantity.unit, target, measured,
                 target.empty() ? "" : verdict(distance >= 0, distance, quantity.digits, quantity.unit)});
    }
  }
  return "Scans at right angles of the middle 120³ voxels, 1 % noise; one value per seed, the uncertainty's\n"
         "of the first seed alone, time and memory of the others. *Drift*: the rigid transform common to all "
         "slices.\n\n" +
         table.text();
}

} // namespace innergs::bench
