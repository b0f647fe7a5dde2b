#include "Core/Job/JobOutline.h"

#include "Core/Base/Failure.h"
#include "Core/Base/NumberText.h"
#include "Core/Device/Devices.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/TimeEstimate.h"
#include "Core/Settings/SettingsTable.h"

namespace innergs {

JobForecast JobOutline::forecast() const {
  JobForecast forecast;
  forecast.refusal = sentenceOf([&] {
    const DeviceUse use = DeviceChoice(settings.device, settings.instructionSet, settings.selection).use;
    forecast.device = use.name;
    forecast.reason = use.reason;
  });
  if (!forecast.refusal.empty()) return forecast;
  sentenceOf([&] { // on failure the time is unknown
    double sum = 0;
    for (const ReconstructionInput& fit : fits) {
      const double seconds = estimateSeconds(fit, settings);
      if (seconds == 0) return;
      sum += seconds;
    }
    forecast.seconds = sum;
  });
  return forecast;
}

std::string JobOutline::key() const {
  std::string key =
      settingsText(settings, 0) + "|" + settings.instructionSet + "|" + std::to_string(settings.threads);
  const auto add = [&key](double x) { key += formatted("|%.17g", x); };
  const auto addGrid = [&](const GridGeometry& grid) {
    for (int a = 0; a < 3; ++a) {
      add(static_cast<double>(grid.size[a]));
      add(grid.spacing[a]);
    }
  };
  for (const ReconstructionInput& fit : fits) {
    key += "|fit";
    add(fit.heldOutFraction);
    add(fit.uncertainty);
    for (const Stack& stack : fit.stacks) {
      addGrid(stack.image.geometry);
      add(stack.thickness);
      add(stack.pixelWidth);
      add(static_cast<double>(stack.profile));
    }
    if (fit.outputGrid) addGrid(*fit.outputGrid);
    if (!fit.masks.empty()) add(maskedShare(fit, 1e9, 0));
  }
  return key;
}

} // namespace innergs
