#include "Core/Settings/SettingsText.h"

#include <locale>
#include <sstream>

namespace innergs {

std::string settingsText(const Settings& s, double heldOutFraction) {
  static constexpr const char* presets[] = {"fast", "balanced", "best", "paper"};
  static constexpr const char* losses[] = {"l1", "l2", "huber"};
  static constexpr const char* starts[] = {"adaptive", "grid"};
  static constexpr const char* schedules[] = {"exponential", "plateau"};
  std::ostringstream text;
  text.imbue(std::locale::classic());
  const auto add = [&](const char* name, const auto& value) {
    text << (text.tellp() > 0 ? "; " : "") << name << '=' << value;
  };
  const auto addIf = [&](const char* name, const auto& value) {
    if (value) add(name, *value);
  };
  const auto addWord = [&](const char* name, const auto& value, const char* const* words) {
    if (value) add(name, words[static_cast<int>(*value)]);
  };
  addWord("preset", std::optional(s.preset), presets);
  add("blending", blendingName(chosenBlending(s)));
  add("selection", selectionName(s.selection));
  addIf("gaussians", s.gaussians);
  addIf("maxGaussians", s.maxGaussians);
  addIf("iterations", s.iterations);
  addIf("members", s.ensembleSize);
  addIf("linearIntensity", s.linearIntensity);
  addWord("initialisation", s.initialisation, starts);
  addWord("loss", s.loss, losses);
  addIf("pointWeight", s.pointWeight);
  addIf("ssimWeight", s.ssimWeight);
  add("huberDelta", s.huberDelta);
  addWord("schedule", s.schedule, schedules);
  if (s.schedule == Schedule::Plateau) {
    add("plateauPatience", s.plateau.patience);
    add("plateauFactor", s.plateau.factor);
    add("plateauLowest", s.plateau.lowest);
    add("plateauThreshold", s.plateau.threshold);
  }
  addIf("densifyEvery", s.densifyEvery);
  if (s.densifyEvery.value_or(0) > 0) {
    addIf("pruneOpacity", s.densify.opacity);
    add("pruneSize", s.densify.size);
    add("densifyGradient", s.densify.gradient);
    add("splitSize", s.densify.split);
  }
  addIf("cutoff", s.cutoff);
  addIf("beta1", s.beta1);
  addIf("beta2", s.beta2);
  addIf("allAxes", s.allAxes);
  addIf("paperStopRule", s.paperStopRule);
  add("relocate", s.relocate);
  add("consistency", s.consistency);
  if (s.fill != 0) add("fill", s.fill);
  add("device", s.device);
  add("seed", s.seed);
  add("heldOutFraction", heldOutFraction);
  return text.str();
}

} // namespace innergs
