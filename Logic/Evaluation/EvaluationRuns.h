#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// Peak of the PSNR: maximum minus minimum over the finite voxels. Throws Error(NoData) when they are all
/// equal.
double intensityRange(const Volume& volume);

/// The Gaussians' volume on `grid`, by the reconstruction job; `report` receives what densification did and,
/// with keepVolumes, the model. Throws Error(Cancelled) when stopped.
Volume reconstructGaussians(const std::vector<Stack>& stacks, const GridGeometry& grid,
                            const EvaluationOptions& options, EvaluationReport& report);

/// Announces a method, runs it and takes its time; throws Error(Cancelled) when stopped before.
struct TimedVolume {
  std::shared_ptr<const Volume> volume;
  double seconds = 0;
};
TimedVolume runMethod(const std::string& name, const EvaluationOptions& options,
                      const std::function<Volume()>& method);

} // namespace innergs
