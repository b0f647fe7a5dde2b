#include "Core/Uncertainty/Uncertainty.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Uncertainty/ErrorCurve.h"
#include "Core/Uncertainty/LocalDetail.h"
#include "Core/Uncertainty/SliceDistance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kFewestHeldOut = 2000; // held-out voxels

/// mm: errors lie beside what causes them, about a quarter of a slice distance away.
double detailRadius(std::span<const Stack> stacks) {
  double distance = 0, pixel = std::numeric_limits<double>::max();
  for (const Stack& stack : stacks) {
    distance = std::max(distance, stack.image.geometry.spacing[2]);
    pixel = std::min({pixel, stack.image.geometry.spacing[0], stack.image.geometry.spacing[1]});
  }
  return std::max(2 * pixel, 0.5 * distance);
}

double deviationOf(const Volume& volume, std::span<const float> near) {
  double sum = 0, squares = 0, count = 0;
  for (std::size_t v = 0; v < near.size(); ++v)
    if (std::isfinite(near[v]) && std::isfinite(volume.voxels[v])) {
      sum += volume.voxels[v];
      squares += static_cast<double>(volume.voxels[v]) * volume.voxels[v];
      ++count;
    }
  return count > 0 ? std::sqrt(std::max(0.0, squares / count - sum / count * sum / count)) : 0;
}

} // namespace

Uncertainty estimateUncertainty(const UncertaintyInput& input, ThreadPool& pool) {
  const double radius = detailRadius(input.stacks);
  const Volume seenDetail = localDetail(input.second, radius, pool);
  const Affine3 toIndex = inverse(input.second.geometry.indexToWorld());
  std::vector<HeldOutError> seen, halves[2];
  for (const HeldOutValue& value : input.seen) {
    float detail = 0;
    if (!std::isfinite(value.difference) ||
        !sampleInside(input.second.geometry, seenDetail.voxels.data(), toIndex(value.at), detail))
      continue;
    seen.push_back({detail, value.difference});
    halves[value.slice % 2].push_back(seen.back());
  }
  if (static_cast<std::int64_t>(seen.size()) < kFewestHeldOut)
    throw Error(ErrorCode::NoData,
                "The uncertainty is unknown: the slices held out for it show too little of the "
                "output. Hold out more slices, or choose a larger output.");
  Uncertainty result;
  result.noise = input.noise;
  result.shading = input.shading;
  std::int64_t held = 0;
  for (int half = 0; half < 2; ++half) {
    const ErrorCurve curve(halves[1 - half]);
    if (curve.empty()) continue;
    for (const HeldOutError& e : halves[half])
      held += std::abs(e.error) <= kNinety * curve.at(e.detail);
    result.samples += static_cast<std::int64_t>(halves[half].size());
  }
  result.coverage = result.samples > 0 ? static_cast<double>(held) / static_cast<double>(result.samples)
                                       : std::numeric_limits<double>::quiet_NaN();
  const ErrorCurve curve(std::move(seen));
  const GridGeometry& grid = input.result.geometry;
  const ErrorTransfer transfer(input.result, input.stacks, input.moved, input.noise, radius, input.fit, pool);
  result.deviation = localDetail(input.result, radius, pool);
  result.measured = measuredVoxels(grid, input.stacks, pool);
  const std::vector<float> near = sliceDistances(grid, input.stacks, pool);
  const double unknown = deviationOf(input.result, near);
  pool.blocks(grid.voxelCount(), 1 << 16, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v) {
      float& value = result.deviation.voxels[static_cast<std::size_t>(v)];
      const double error = std::hypot(transfer.deviation(curve.at(value), value, near[v]),
                                      input.shading * input.result.voxels[static_cast<std::size_t>(v)]);
      value = static_cast<float>(std::isfinite(near[v]) ? std::min(error, unknown) : unknown);
    }
  });
  return result;
}

Volume deviationOn(const GridGeometry& grid, const Volume& deviation, ThreadPool& pool) {
  const float largest = *std::max_element(deviation.voxels.begin(), deviation.voxels.end());
  Volume on{grid, std::vector<float>(static_cast<std::size_t>(grid.voxelCount()), largest)};
  const Affine3 map = inverse(deviation.geometry.indexToWorld()) * grid.indexToWorld();
  const auto& n = grid.size;
  pool.run(n[1] * n[2], [&](std::int64_t row) {
    for (std::int64_t i = 0; i < n[0]; ++i)
      sampleInside(
          deviation.geometry, deviation.voxels.data(),
          map({static_cast<double>(i), static_cast<double>(row % n[1]), static_cast<double>(row / n[1])}),
          on.voxels[static_cast<std::size_t>(i + n[0] * row)]);
  });
  return on;
}

std::string uncertaintySentence(const Uncertainty& u) {
  const double measured = static_cast<double>(std::count(u.measured.begin(), u.measured.end(), 1)) /
                          static_cast<double>(std::max<std::size_t>(1, u.measured.size()));
  const std::string known =
      std::isfinite(u.coverage)
          ? formatted("Its 90 %% intervals held %.0f %% of %s voxels of held-out slices not used to learn "
                      "them; where slices disagree, as when the patient moved, they hold fewer. ",
                      100 * u.coverage, countText(u.samples).c_str())
          : "How often its intervals hold is unknown: a single slice was held out. ";
  const std::string shading =
      u.shading > 0
          ? formatted("They also allow for a smooth shading of %.1f %% (standard deviation) that all "
                      "scans may share, which no held-out slice can show. ",
                      100 * u.shading)
          : "";
  return known + shading + formatted("Slices measured %.0f %% of the output's voxels.", 100 * measured);
}

} // namespace innergs
