#pragma once
#include "Core/Job/MemoryEstimate.h"

namespace innergs {

/// Where a job would run and how long it would take.
struct JobForecast {
  std::string refusal;        // why the device cannot run it, a sentence; "" if it can
  std::string device, reason; // its name; a sentence on why it was chosen
  double seconds = 0;         // rough; 0: unknown
};

/// The fits that a job runs one after the other, for estimates; only the mask needs voxels.
struct JobOutline {
  Settings settings;
  std::vector<ReconstructionInput> fits;

  MemoryNeed memory() const { return memoryNeed(fits, settings); }
  /// Slow at the first call: loads devices and times a short fit.
  JobForecast forecast() const;
  /// Outlines with the same key have the same forecast.
  std::string key() const;
};

} // namespace innergs
