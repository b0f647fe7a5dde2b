#include "Evaluation/EvaluationRuns.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

namespace innergs {

double intensityRange(const Volume& volume) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (float v : volume.voxels)
    if (std::isfinite(v)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  if (!(low < high))
    throw Error(ErrorCode::NoData,
                "The volume is constant or has no finite voxel: a PSNR has no meaning for it.");
  return double(high) - double(low);
}

Volume reconstructGaussians(const std::vector<Stack>& stacks, const GridGeometry& grid,
                            const EvaluationOptions& options, EvaluationReport& report) {
  ReconstructionInput input;
  input.stacks = stacks;
  input.outputGrid = grid;
  if (options.mask) input.masks = {*options.mask};
  input.uncertainty = options.uncertainty;
  ReconstructionJob job(std::move(input), options.settings);
  if (options.progress) job.onProgress(options.progress);
  ReconstructionResult result = job.run(options.stop);
  if (result.cancelled) throw Error(ErrorCode::Cancelled, "The evaluation was cancelled.");
  report.densified = result.densified;
  report.uncertainty = std::move(result.uncertainty);
  report.notes.insert(report.notes.end(), result.warnings.begin(), result.warnings.end());
  if (options.keepVolumes) report.model = result.model;
  return std::move(result.volume);
}

TimedVolume runMethod(const std::string& name, const EvaluationOptions& options,
                      const std::function<Volume()>& method) {
  if (options.stop.stop_requested()) throw Error(ErrorCode::Cancelled, "The evaluation was cancelled.");
  if (options.onMethod) options.onMethod(name);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpuStart = std::clock();
  auto volume = std::make_shared<const Volume>(method());
  return {std::move(volume), secondsSince(start),
          static_cast<double>(std::clock() - cpuStart) / CLOCKS_PER_SEC, peakMemory()};
}

} // namespace innergs
