#include "Core/Job/Resume.h"

#include "Core/Base/Error.h"
#include "Core/Settings/SettingsTable.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::string settingsKey(const Settings& settings, const std::string& fingerprint) {
  const Settings usual; // left out, so that a new setting leaves older keys as they are
  std::string key;
  for (const Setting& row : settingsTable()) {
    const std::string text = row.textIn(settings);
    if (row.part == Setting::Part::Fit && text != row.textIn(usual) && row.hasEffectIn(settings))
      key += row.name + ("=" + text) + "; ";
  }
  return key + "input=" + fingerprint;
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
