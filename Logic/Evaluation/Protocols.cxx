#include "Evaluation/Protocols.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Evaluation/EvaluationRuns.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>

namespace innergs {

const char* planeName(Plane plane) {
  return plane == Plane::Axial ? "axial" : plane == Plane::Coronal ? "coronal" : "sagittal";
}

int sliceAxis(const GridGeometry& geometry, Plane plane) {
  // Patient axis (x: right-left, y: front-back, z: foot-head) for each plane; the best of the six
  // assignments.
  constexpr int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  double best = -1;
  const int* axisOfPatientAxis = permutations[0];
  for (const auto& p : permutations) {
    double sum = 0;
    for (int r = 0; r < 3; ++r)
      sum += std::abs(geometry.direction[r][p[r]]);
    if (sum > best + 1e-9) {
      best = sum;
      axisOfPatientAxis = p;
    }
  }
  return axisOfPatientAxis[plane == Plane::Axial ? 2 : plane == Plane::Coronal ? 1 : 0];
}

Plane planeAcross(const GridGeometry& geometry, int axis) {
  for (const Plane plane : {Plane::Axial, Plane::Coronal})
    if (sliceAxis(geometry, plane) == axis) return plane;
  return Plane::Sagittal;
}

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
          static_cast<double>(std::clock() - cpuStart) / CLOCKS_PER_SEC};
}

} // namespace innergs
