#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// Peak of the PSNR: maximum minus minimum of the finite voxels. Throws Error(NoData) if all are equal.
double intensityRange(const Volume& volume);

/// Reconstructs the Gaussians' volume on `grid`; `report` receives the densification counts, warnings and,
/// with keepVolumes, the model. Throws Error(Cancelled) when stopped.
Volume reconstructGaussians(const std::vector<Stack>& stacks, const GridGeometry& grid,
                            const EvaluationOptions& options, EvaluationReport& report);

/// Announces a method, runs it and measures its time (CPU time: of the whole process; on Windows wall time)
/// and the most memory that the process has had resident until then
/// (bytes; 0: unknown); throws Error(Cancelled) if stopped before.
struct TimedVolume {
  std::shared_ptr<const Volume> volume;
  double seconds = 0, cpuSeconds = 0;
  std::int64_t peakMemory = 0;
};
TimedVolume runMethod(const std::string& name, const EvaluationOptions& options,
                      const std::function<Volume()>& method);

} // namespace innergs
