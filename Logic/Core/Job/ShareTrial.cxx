#include "Core/Job/ShareTrial.h"

#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Image/Simulate.h"
#include "Core/Job/JobInput.h"
#include "Core/Uncertainty/LocalDetail.h"
#include "Core/Uncertainty/SimulatedGrids.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr std::int64_t kEdge = 64;   // voxels of the part
constexpr double kFewestSlices = 12; // of the thickest scan, if that takes no more than kLongestEdge
constexpr std::int64_t kLongestEdge = 96;
constexpr std::int64_t kBesideFaces = 4; // voxels
constexpr double kLeastShare = 0.05, kMostShare = 0.4;
constexpr double kTakenOff = 0.15;     // of the best share
constexpr double kTakenOffByNoise = 8; // times the noise, likewise
constexpr std::int64_t kOverview = 96; // voxels along an axis, to look for detail

/// Part of a grid around a place (LPS mm).
GridGeometry partAround(const GridGeometry& grid, const Vec3& middle, std::span<const Stack> stacks) {
  const Vec3 index = inverse(grid.indexToWorld())(middle);
  std::array<std::int64_t, 3> first, size;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t edge = std::clamp<std::int64_t>(
        std::llround(kFewestSlices * coarsestSlices(stacks) / grid.spacing[a]), kEdge, kLongestEdge);
    size[a] = std::min(edge, grid.size[a]);
    first[a] = std::clamp<std::int64_t>(std::llround(index[a]) - size[a] / 2, 0, grid.size[a] - size[a]);
  }
  return cropped(grid, first, size);
}

/// The part with another slice beside each face.
GridGeometry withMargin(const GridGeometry& part, double margin) {
  GridGeometry wide = part;
  Vec3 before{};
  for (int a = 0; a < 3; ++a) {
    const std::int64_t voxels = std::llround(std::ceil(margin / part.spacing[a]));
    wide.size[a] += 2 * voxels;
    before[a] = -static_cast<double>(voxels);
  }
  wide.origin = part.indexToWorld()(before);
  return wide;
}

ShareTrial trialOn(const GridGeometry& part, std::span<const Stack> stacks, const GridGeometry& domain,
                   const Settings& settings) {
  ShareTrial trial;
  trial.refit = simulatedFit(simulatedGrids(stacks, part), part, domain, {}, settings);
  trial.refit.input.heldOutFraction = 0;
  auto& scans = trial.refit.input.stacks;
  if (std::any_of(scans.begin(), scans.end(),
                  [](const Stack& scan) { return scan.image.geometry.size[2] < 3; }))
    scans.clear();
  return trial;
}

} // namespace

ShareTrial shareTrial(const std::function<Volume(const GridGeometry&)>& render, std::span<const Stack> stacks,
                      const GridGeometry& domain, const Settings& settings, double noise, ThreadPool& pool) {
  const double coarsest = coarsestSlices(stacks);
  const Vec3 middle = middleOf(localDetail(render(reduced(domain, kOverview)), coarsest, pool));
  ShareTrial trial = trialOn(partAround(domain, middle, stacks), stacks, domain, settings);
  trial.truth = render(*trial.refit.input.outputGrid);
  const Volume wide = render(withMargin(trial.truth.geometry, coarsest));
  std::uint64_t seed = 0;
  for (Stack& scan : trial.refit.input.stacks) {
    scan.image.voxels.assign(static_cast<std::size_t>(scan.image.geometry.voxelCount()), 0.f);
    scan.image.voxels = projectToStack(wide, scan, pool);
    addNoise(scan.image.voxels, noise, 7919 * ++seed);
  }
  return trial;
}

ShareTrial shareTrialOutline(std::span<const Stack> stacks, const Settings& settings) {
  const GridGeometry domain = dataDomain(stacks);
  return trialOn(partAround(domain, domain.centre(), stacks), stacks, domain, settings);
}

double chosenShare(const Volume& truth, const Volume& unmixed, const Volume& mixed, double noise) {
  const auto& n = truth.geometry.size;
  const auto counts = [&](int axis, std::int64_t at) {
    const std::int64_t beside = std::min(kBesideFaces, (n[axis] - 1) / 4);
    return at >= beside && at < n[axis] - beside;
  };
  double product = 0, square = 0;
  std::size_t v = 0;
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i, ++v) {
        if (!counts(0, i) || !counts(1, j) || !counts(2, k)) continue;
        const double change = static_cast<double>(mixed.voxels[v]) - unmixed.voxels[v];
        product += change * (static_cast<double>(truth.voxels[v]) - unmixed.voxels[v]);
        square += change * change;
      }
  const double best = square > 0 ? kTriedShare * product / square : 0;
  const double share = best - kTakenOff - kTakenOffByNoise * noise;
  return share < kLeastShare ? 0 : std::min(share, kMostShare);
}

} // namespace innergs
