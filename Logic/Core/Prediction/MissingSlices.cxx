#include "Core/Prediction/MissingSlices.h"

#include "Core/Prediction/CandidateWeights.h"

namespace innergs {
namespace {

constexpr double kFewestMissing = 0.005; // of the known voxels; fewer are not worth learning twice

} // namespace

std::vector<std::size_t> missingVoxels(const Stack& scan, int parity) {
  std::vector<std::size_t> missing;
  const auto& n = scan.image.geometry.size;
  const std::int64_t plane = n[0] * n[1];
  std::int64_t known = 0;
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v)
      if (isKnown(scan, v))
        ++known;
      else if (k % 2 == parity && k > 0 && k + 1 < n[2] && isKnown(scan, v - plane) &&
               isKnown(scan, v + plane))
        missing.push_back(static_cast<std::size_t>(v));
  if (static_cast<double>(missing.size()) < kFewestMissing * static_cast<double>(known)) missing.clear();
  return missing;
}

Stack withInterpolated(const Stack& scan, std::span<const std::vector<std::size_t>> voxels,
                       ThreadPool& pool) {
  Stack filled = scan;
  const std::vector<float> complete = completeSlices(scan, pool);
  for (const auto& part : voxels)
    for (const std::size_t v : part) {
      filled.image.voxels[v] = complete[v];
      if (!filled.observed.empty()) filled.observed[v] = 1;
    }
  return filled;
}

Stack fromSlice(const Stack& scan, std::int64_t first) {
  Stack rest = scan;
  GridGeometry& g = rest.image.geometry;
  g.origin = g.indexToWorld()({0, 0, static_cast<double>(first)});
  g.size[2] -= first;
  const std::int64_t skipped = first * g.size[0] * g.size[1];
  rest.image.voxels.erase(rest.image.voxels.begin(), rest.image.voxels.begin() + skipped);
  if (!rest.observed.empty()) rest.observed.erase(rest.observed.begin(), rest.observed.begin() + skipped);
  return rest;
}

std::vector<std::int64_t> probeSlices(const Stack& scan) {
  std::vector<std::int64_t> probes;
  for (std::int64_t k = 1; k + 1 < scan.image.geometry.size[2]; k += 4)
    probes.push_back(k);
  return probes;
}

} // namespace innergs
