#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace innergs::bench {

/// The outcome of one measurement: its JSON, or why there is none.
struct Outcome {
  std::optional<nlohmann::json> json;
  std::string missing; // "skipped: …" or "failed: …"
};

/// Sections of Docs/benchmarks.md, in Markdown. Every row says what it was measured on and, if there is one,
/// its target.
std::string speedTable(const Outcome& microbenchmarks);

struct PaperOutcomes {
  Outcome paperCount, large, responsiveness; // 74,088 and 300,000 Gaussians
};
std::string paperTable(const PaperOutcomes& outcomes);

struct HeldOutOutcome {
  std::string volume, heldOutCase; // "studyforrest T1", "keep-every-4"; no case: all of them
  Outcome outcome;
};
std::string heldOutTable(const std::vector<HeldOutOutcome>& outcomes);

/// The cases of stackTable().
inline const std::string kStill = "three stacks, still", kTwoStill = "two stacks, still",
                         kMoved = "±3 mm, ±3° per slice", kMovedMuch = "±5 mm, ±5° per slice",
                         kShaded = "still, shading ±40 %";
struct StackOutcome {
  std::string volume, stacksCase; // no case: all of them
  int seed = 1;
  Outcome outcome;
};
/// One row per quantity of a case, with the values of all seeds.
std::string stackTable(const std::vector<StackOutcome>& outcomes);

/// One row per volume: the gain over the best interpolation, on average and in the worst case.
std::string sweepTable(const std::vector<HeldOutOutcome>& outcomes);

} // namespace innergs::bench
