#include "Core/Job/Resume.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::string settingsKey(const Settings& s, const std::string& fingerprint) {
  const auto number = [](double x) { return formatted("%.17g", x); };
  std::string schedule, densify; // only what has an effect
  if (s.schedule == Schedule::Plateau)
    schedule = ", plateau " + std::to_string(s.plateau.patience) + " " + number(s.plateau.factor) + " " +
               number(s.plateau.lowest) + " " + number(s.plateau.threshold);
  if (s.densifyEvery.value_or(0) > 0)
    densify = ", densify " + std::to_string(*s.densifyEvery) + " " + number(s.densify.opacity.value_or(0)) +
              " " + number(s.densify.size) + " " + number(s.densify.gradient) + " " +
              number(s.densify.split) + " " + std::to_string(s.maxGaussians.value_or(0));
  if (s.allAxes.value_or(false)) schedule += ", all axes";
  if (s.selection != Selection::Exact) schedule += std::string(", selection ") + selectionName(s.selection);
  const auto other = [&](const char* name, const std::optional<double>& value, double usual) {
    if (value.value_or(usual) != usual) schedule += name + number(*value);
  };
  other(", cutoff ", s.cutoff, 2.2);
  other(", beta1 ", s.beta1, 0.8);
  other(", beta2 ", s.beta2, 0.95);
  return "preset " + std::to_string(static_cast<int>(s.preset)) + ", blending " +
         std::to_string(static_cast<int>(chosenBlending(s))) + ", linear " +
         std::to_string(s.linearIntensity.value_or(false)) + ", start " +
         std::to_string(static_cast<int>(s.initialisation.value_or(Initialisation::Adaptive))) + ", loss " +
         std::to_string(static_cast<int>(s.loss.value_or(LossKind::L2))) + " " + number(s.huberDelta) + " " +
         number(s.pointWeight.value_or(1)) + " " + number(s.ssimWeight.value_or(0)) + schedule + densify +
         ", gaussians " + std::to_string(s.gaussians.value_or(0)) + ", iterations " +
         std::to_string(s.iterations.value_or(0)) + ", members " +
         std::to_string(s.ensembleSize.value_or(1)) + ", stop rule " +
         std::to_string(s.paperStopRule.value_or(false)) + ", relocate " + std::to_string(s.relocate) +
         ", seed " + std::to_string(s.seed) + ", input " + fingerprint;
}

void checkResumable(const Checkpoint& c, int iterations) {
  const auto require = [](bool ok) {
    if (!ok)
      throw Error(ErrorCode::FileFormat,
                  "The state of the fit to resume is damaged: start anew or from an earlier model.");
  };
  require(c.finished >= 0 && c.finished <= c.field.size());
  require(c.iteration >= 0 && c.iteration <= iterations);
  const auto open = static_cast<std::size_t>(c.field.size() - c.finished);
  for (const auto* moment : {&c.moment1, &c.moment2}) {
    require(moment->size() == (c.moment1.empty() ? 0 : 16 * open));
    const float lowest = moment == &c.moment2 ? 0.f : -1e30f; // the second is a mean of squares
    require(std::all_of(moment->begin(), moment->end(), [&](float x) { return x >= lowest && x <= 1e30f; }));
  }
  require(!c.moment1.empty() || open == 0);
  require(c.losses.size() <= static_cast<std::size_t>(c.iteration));
  require(std::all_of(c.losses.begin(), c.losses.end(), [](float x) { return std::isfinite(x); }));
  require(c.gradients.empty() || c.gradients.size() == open);
  require(std::all_of(c.gradients.begin(), c.gradients.end(), [](float x) { return x >= 0 && x <= 1e30f; }));
}

} // namespace innergs
