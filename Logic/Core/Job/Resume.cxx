#include "Core/Job/Resume.h"

#include "Core/Base/Error.h"
#include "Core/Settings/SettingsTable.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::string settingsKey(const Settings& settings, const std::string& fingerprint) {
  const Settings usual; // omits defaults, so that a new setting leaves older keys valid
  std::string key;
  for (const Setting& row : settingsTable()) {
    const std::string text = row.textIn(settings);
    if (row.part == Setting::Part::Fit && text != row.textIn(usual) && row.hasEffectIn(settings))
      key += row.name + ("=" + text) + "; ";
  }
  return key + "input=" + fingerprint;
}

void checkResumable(const Model& model, int iterations) {
  const auto require = [](bool ok) {
    if (!ok)
      throw Error(ErrorCode::FileFormat,
                  "The state of the fit to resume is damaged: start again or from an earlier model.");
  };
  const OptimizerState& optimizer = model.optimizer;
  require(model.finished >= 0 && model.finished <= model.field.size());
  require(model.iteration >= 0 && model.iteration <= iterations);
  const auto open = static_cast<std::size_t>(model.field.size() - model.finished);
  for (const auto* moment : {&optimizer.moment1, &optimizer.moment2}) {
    require(moment->size() == (optimizer.moment1.empty() ? 0 : 16 * open));
    const float lowest = moment == &optimizer.moment2 ? 0.f : -1e30f; // a mean of squares
    require(std::all_of(moment->begin(), moment->end(), [&](float x) { return x >= lowest && x <= 1e30f; }));
  }
  require(!model.complete() || open == 0);
  require(optimizer.losses.size() <= static_cast<std::size_t>(model.iteration));
  require(std::all_of(optimizer.losses.begin(), optimizer.losses.end(),
                      [](float x) { return std::isfinite(x); }));
  require(optimizer.gradients.empty() || optimizer.gradients.size() == open);
  require(std::all_of(optimizer.gradients.begin(), optimizer.gradients.end(),
                      [](float x) { return x >= 0 && x <= 1e30f; }));
}

} // namespace innergs
