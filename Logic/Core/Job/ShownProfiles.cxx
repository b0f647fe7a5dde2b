#include "Core/Job/ShownProfiles.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"

#include <algorithm>
#include <array>

namespace innergs {
namespace {

constexpr std::array<std::int64_t, 3> kMiddle{128, 128, 64}; // voxels, for speed
constexpr double kSure = 0.5;                              // least confidence
constexpr double kThicker = 1.5; // from here on, slices of real scans overlap or are interpolated

Stack middleOf(const Stack& stack) {
  const auto& n = stack.image.geometry.size;
  IndexBlock block;
  for (int a = 0; a < 3; ++a) {
    block.size[a] = std::min(n[a], kMiddle[a]);
    block.first[a] = (n[a] - block.size[a]) / 2;
  }
  Stack middle;
  middle.profile = stack.profile;
  middle.thickness = effectiveThickness(stack);
  middle.image = cropped(stack.image, block);
  if (!stack.observed.empty())
    middle.observed = cropped(Mask{stack.image.geometry, stack.observed}, block).voxels;
  return middle;
}

std::string millimetres(double value) {
  return numberText(std::round(value * 10) / 10);
}

/// Empty where the estimate says nothing.
std::string sentenceOf(const ProfileEstimate& estimate, const Stack& stack) {
  if (!estimate.known || estimate.confidence < kSure) return {};
  const double fitted = stack.profile == SliceProfile::Point ? 0 : effectiveThickness(stack);
  if (estimate.thickness < kThicker * estimate.spacing)
    return "look no thicker than their distance of " + millimetres(estimate.spacing) + " mm" +
           (estimate.thickness < estimate.spacing && fitted >= kThicker * estimate.spacing
                ? ", but were fitted as " + millimetres(fitted) + " mm thick: check their thickness."
                : ".");
  return "look " + millimetres(estimate.thickness) + " mm thick, " + millimetres(estimate.spacing) +
         " mm apart" +
         (estimate.thickness >= kThicker * fitted
              ? ", but were fitted as " + (fitted > 0 ? millimetres(fitted) + " mm thick" : "thin") +
                    ": if they overlap or the scanner interpolated them, state their thickness."
              : ".");
}

} // namespace

ShownProfiles shownProfiles(std::span<const Stack> stacks, ThreadPool& pool) {
  ShownProfiles shown;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    if (!stacks[s].poses.empty()) {
      shown.scans.emplace_back();
      continue;
    }
    shown.scans.push_back(estimateProfile(middleOf(stacks[s]), pool));
    const std::string said = sentenceOf(shown.scans.back(), stacks[s]);
    if (said.empty()) continue;
    shown.sentence += (shown.sentence.empty() ? "" : " ") +
                      (stacks.size() == 1 ? "The slices " : "The slices of " + nameOf(stacks[s], s) + " ") +
                      said;
  }
  return shown;
}

} // namespace innergs
