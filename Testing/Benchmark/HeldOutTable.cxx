#include "Markdown.h"
#include "Scores.h"
#include "Tables.h"

#include <cmath>

namespace innergs::bench {
namespace {

double bestInterpolation(const Scores& s) {
  return s.best({"linear", "cubic", "lanczos"}, "psnr");
}

/// What the Gaussians must exceed, and by how much at least.
struct Target {
  const char* over;
  double reference, margin;
  std::string text() const {
    return margin > 0 ? "≥ " + withSign(margin, 1) + " dB over " + over : std::string("not below ") + over;
  }
};

std::vector<Target> targets(const std::string& volume, const std::string& heldOutCase, const Scores& s) {
  std::vector<Target> all{{"best interpolation", bestInterpolation(s), 0}};
  if (volume != "studyforrest T1") return all;
  if (heldOutCase == "keep-every-4") all = {{"best interpolation", bestInterpolation(s), 0.5}};
  if (heldOutCase == "thick-4")
    all = {{"cubic", s.psnr("cubic"), 0.8}, {"back-projection", s.psnr("backprojection"), 0.4}};
  if (heldOutCase == "orthogonal-2-thick-4") all = {{"back-projection", s.psnr("backprojection"), 0.7}};
  return all;
}

std::string measuredOn(const std::string& heldOutCase, const nlohmann::json& report) {
  const std::string where = heldOutCase.starts_with("keep-every") ? "held-out slices" : "whole volume";
  return where + ", body, " + fixed(report.at("voxels").get<double>() / 1e6, 2) + " M voxels";
}

} // namespace

std::string heldOutTable(const std::vector<HeldOutOutcome>& outcomes) {
  MarkdownTable table({"volume", "case", "measured on", "Gaussians", "linear", "cubic", "Lanczos", "average",
                       "back-projection", "total variation", "over best interpolation",
                       "over back-projection", "target", "met", "seconds", "CPU seconds"});
  for (const auto& [volume, heldOutCase, outcome] : outcomes) {
    if (!outcome.json) {
      table.add({volume, heldOutCase.empty() ? "all" : heldOutCase, outcome.missing});
      continue;
    }
    const Scores s(*outcome.json);
    const double psnr = s.psnr("gaussians");
    std::string wanted, met;
    for (const Target& t : targets(volume, heldOutCase, s)) {
      const double distance = psnr - t.reference - t.margin;
      wanted += (wanted.empty() ? "" : "; ") + t.text();
      met += (met.empty() ? "" : "; ") + verdict(distance >= 0, distance, 2, "dB");
    }
    table.add({volume, heldOutCase, measuredOn(heldOutCase, *outcome.json), s.text("gaussians"),
               s.text("linear"), s.text("cubic"), s.text("lanczos"), s.text("average"),
               s.text("backprojection"), s.text("totalvariation"), withSign(psnr - bestInterpolation(s), 2),
               std::isnan(s.psnr("backprojection")) ? "" : withSign(psnr - s.psnr("backprojection"), 2),
               wanted, met, fixed(s.get("gaussians", "seconds"), 1),
               fixed(s.get("gaussians", "cpu_seconds"), 1)});
  }
  return table.text();
}

} // namespace innergs::bench
