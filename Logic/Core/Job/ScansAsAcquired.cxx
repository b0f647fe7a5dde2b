#include "Core/Job/ScansAsAcquired.h"

#include "Core/Acquisition/InterpolatedPixels.h"
#include "Core/Base/NumberText.h"
#include "Core/Job/JobInput.h"

#include <algorithm>
#include <utility>

namespace innergs {
namespace {

bool complete(const Stack& stack) {
  const GridGeometry& g = stack.image.geometry;
  return stack.poses.empty() && std::min({g.size[0], g.size[1], g.size[2]}) > 0 &&
         stack.image.voxels.size() == static_cast<std::size_t>(g.voxelCount()) &&
         (stack.observed.empty() || stack.observed.size() == stack.image.voxels.size());
}

std::string sentenceOf(const Stack& stored, const Stack& acquired, const std::array<double, 2>& factors) {
  const Vec3 &from = acquired.image.geometry.spacing, &to = stored.image.geometry.spacing;
  const auto mm = [](double x) { return numberText(std::round(x * 100) / 100); };
  const std::string size = factors[0] == 1   ? mm(from[1]) + " mm along its columns"
                           : factors[1] == 1 ? mm(from[0]) + " mm along its rows"
                                             : mm(from[0]) + " × " + mm(from[1]) + " mm";
  return "Its pixels of " + mm(to[0]) + " × " + mm(to[1]) + " mm look interpolated from about " + size +
         ": they were fitted at that size.";
}

} // namespace

ScansAsAcquired::ScansAsAcquired(ReconstructionInput& input, const Settings& settings, ThreadPool& pool)
    : input_(input), outputGrid_(input.outputGrid), cropToMask_(input.cropToMask) {
  auto& scans = input.stacks;
  others_.resize(scans.size());
  if (settings.acquiredPixels && settings.preset != Preset::Paper &&
      std::all_of(scans.begin(), scans.end(), complete))
    for (std::size_t s = 0; s < scans.size(); ++s) {
      const std::array<double, 2> factors = interpolationFactors(scans[s], pool);
      if (factors == std::array<double, 2>{1, 1}) continue;
      others_[s] = withLargerPixels(scans[s], factors, pool);
      others_[s]->remarks.push_back((scans[s].name.empty() ? "" : scans[s].name + ": ") +
                                    sentenceOf(scans[s], *others_[s], factors));
    }
  const bool changed =
      std::any_of(others_.begin(), others_.end(), [](const auto& s) { return s.has_value(); });
  if (changed && !outputGrid_) {
    outputGrid_ = defaultOutputGrid(scans);
    cropToMask_ = true;
  }
  exchange();
  for (const Stack& scan : scans)
    widths_.push_back(pixelWidth(scan, scans, settings));
  for (std::size_t s = 0; s < scans.size(); ++s)
    std::swap(scans[s].pixelWidth, widths_[s]);
}

ScansAsAcquired::~ScansAsAcquired() {
  for (std::size_t s = 0; s < widths_.size(); ++s)
    std::swap(input_.stacks[s].pixelWidth, widths_[s]);
  exchange();
}

void ScansAsAcquired::exchange() {
  for (std::size_t s = 0; s < others_.size(); ++s)
    if (others_[s]) std::swap(input_.stacks[s], *others_[s]);
  std::swap(input_.outputGrid, outputGrid_);
  std::swap(input_.cropToMask, cropToMask_);
}

} // namespace innergs
