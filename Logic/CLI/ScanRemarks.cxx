#include "CLI/ScanRemarks.h"

#include "Core/Acquisition/SliceOrder.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <set>

namespace innergs::cli {
namespace {

std::string assumedThickness(std::span<const Stack> stacks) {
  std::vector<std::string> names;
  for (const Stack& stack : stacks)
    if (stack.thickness == 0 && stack.profile != SliceProfile::Point)
      names.push_back(fmt::format("{} ({:.4g} mm)", stack.name, stack.image.geometry.spacing[2]));
  if (names.empty()) return {};
  return fmt::format("Where no file says how thick slices are, they are taken to be as thick as they lie "
                     "apart: {}. If they are thinner or overlap, give --thickness.",
                     fmt::join(names, ", "));
}

std::string interleaving(std::span<const Stack> stacks, const Settings& settings) {
  if (stacks.size() < 2 || settings.sliceMotion == SliceMotionKind::Off) return {};
  std::set<int> counts;
  std::vector<std::string> scans;
  for (const Stack& stack : stacks) {
    if (stack.times.empty()) continue;
    counts.insert(interleavedPasses(stack.times));
    scans.push_back(fmt::format("{} {}", stack.name, sliceOrderText(stack.times)));
  }
  if (counts.empty() || *counts.rbegin() < 2 || counts == std::set{settings.packets}) return {};
  const std::string order = fmt::format("Slices were acquired: {}. ", fmt::join(scans, ", "));
  if (counts.size() > 1)
    return order + "--packets, one number for all scans, cannot move the passes of each as wholes.";
  return order +
         fmt::format("--packets {} moves each pass as a whole: more robust, if the patient moved only "
                     "between the passes.",
                     *counts.begin());
}

} // namespace

std::vector<std::string> scanRemarks(std::span<const Stack> stacks, const Settings& settings) {
  std::vector<std::string> remarks{assumedThickness(stacks), interleaving(stacks, settings)};
  std::erase(remarks, "");
  return remarks;
}

} // namespace innergs::cli
