#pragma once
#include "Core/Job/MemoryEstimate.h"

namespace innergs {

/// Where a job would run and how long it would take.
struct JobForecast {
  std::string refusal;        // of the device, a sentence; "" when it can run
  std::string device, reason; // its name; why that one, a sentence
  double seconds = 0;         // roughly; 0: unknown
};

/// The fits that a job makes one after the other, for estimates: without voxels but for the mask's.
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
