#include "Core/Settings/Settings.h"

#include "Core/Base/Error.h"
#include "Core/Settings/SettingsTable.h"

namespace innergs {
namespace {

void require(bool ok, const std::string& sentence) {
  if (!ok) throw Error(ErrorCode::InvalidArgument, sentence);
}

} // namespace

Blending chosenBlending(const Settings& s) {
  return s.blending.value_or(s.preset == Preset::Paper ? Blending::Alpha : Blending::Normalised);
}

Settings withPresetValues(Settings s) {
  const bool paper = s.preset == Preset::Paper;
  const auto fill = [](auto& member, auto value) {
    if (!member) member = value;
  };
  fill(s.blending, chosenBlending(s));
  fill(s.initialisation, paper ? Initialisation::Grid : Initialisation::Adaptive);
  fill(s.loss, paper ? LossKind::L1 : LossKind::L2);
  fill(s.lossWeight, paper ? 0.8 : 1.0);
  fill(s.ssimWeight, paper ? 0.4 : 0.0);
  fill(s.schedule, paper ? Schedule::Plateau : Schedule::Exponential);
  fill(s.cutoff, 2.2);
  fill(s.beta1, 0.8);
  fill(s.beta2, 0.95);
  fill(s.densifyEvery, paper || s.maxGaussians ? 10 : 0);
  fill(s.densify.opacity, s.blending == Blending::Alpha ? 0.3 : 0.01);
  fill(s.paperStopRule, paper);
  return s;
}

void checkSettings(const Settings& settings) {
  for (const Setting& row : settingsTable())
    row.check(settings);
  const Settings s = withPresetValues(settings);
  require(*s.lossWeight > 0 || *s.ssimWeight > 0, "The loss and 1 − SSIM must not both have the weight 0.");
  require(!s.maxGaussians || !s.gaussians || *s.maxGaussians >= *s.gaussians,
          "The largest number of Gaussians must not be below the number at the start.");
  if (s.blending == Blending::Normalised) return;
  const std::string name = s.blending == Blending::Additive ? "Additive" : "Alpha";
  require(s.ensembleSize.value_or(1) <= 1, name + " fields cannot be merged: use one field.");
  require(!s.linearIntensity.value_or(false),
          name + " blending has no linear intensity: use only one of the two.");
}

} // namespace innergs
