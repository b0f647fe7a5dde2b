#pragma once
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// Gives scans, while it lives, the pixels with which they were acquired (Settings::acquiredPixels,
/// InterpolatedPixels.h) and the widths over which these average (pixelWidth()). The output grid stays as it
/// would have been. Scans with poses, and all with the paper's preset, keep their pixels. Throws
/// Error(Cancelled).
class ScansAsAcquired {
public:
  ScansAsAcquired(ReconstructionInput& input, const Settings& settings, ThreadPool& pool);
  ~ScansAsAcquired();
  ScansAsAcquired(const ScansAsAcquired&) = delete;
  ScansAsAcquired& operator=(const ScansAsAcquired&) = delete;

private:
  void exchange();

  ReconstructionInput& input_;
  std::vector<std::optional<Stack>> others_; // those not in place
  std::vector<double> widths_;
  std::optional<GridGeometry> outputGrid_;
  bool cropToMask_;
};

} // namespace innergs
