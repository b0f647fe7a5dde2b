#include "Core/Resume.h"

#include "Core/Error.h"

#include <algorithm>

namespace innergs {

std::string settingsKey(const Settings& s, const std::string& fingerprint) {
  const auto number = [](double x) { return std::to_string(x); };
  return "preset " + std::to_string(static_cast<int>(s.preset)) + ", blending " +
         std::to_string(static_cast<int>(s.blending)) + ", linear " +
         std::to_string(s.linearIntensity.value_or(false)) + ", start " +
         std::to_string(static_cast<int>(s.initialisation)) + ", loss " +
         std::to_string(static_cast<int>(s.loss)) + " " + number(s.huberDelta) + " " + number(s.ssimWeight) +
         ", gaussians " + std::to_string(s.gaussians.value_or(0)) + ", iterations " +
         std::to_string(s.iterations.value_or(0)) + ", members " + std::to_string(s.members.value_or(1)) +
         ", stop rule " + std::to_string(s.paperStopRule) + ", relocate " + std::to_string(s.relocate) +
         ", seed " + std::to_string(s.seed) + ", input " + fingerprint;
}

void checkResumable(const Checkpoint& c, int sweeps) {
  const auto require = [](bool ok) {
    if (!ok)
      throw Error(ErrorCode::FileFormat,
                  "The state of the fit to resume is damaged: start anew or from an earlier model.");
  };
  require(c.finished >= 0 && c.finished <= c.field.size());
  require(c.iteration >= 0 && c.iteration <= sweeps);
  const auto open = static_cast<std::size_t>(c.field.size() - c.finished);
  for (const auto* moment : {&c.moment1, &c.moment2}) {
    require(moment->size() == (c.moment1.empty() ? 0 : 16 * open));
    const float lowest = moment == &c.moment2 ? 0.f : -1e30f; // the second is a mean of squares
    require(std::all_of(moment->begin(), moment->end(), [&](float x) { return x >= lowest && x <= 1e30f; }));
  }
  require(!c.moment1.empty() || open == 0);
}

} // namespace innergs
