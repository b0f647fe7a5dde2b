#include "Core/Fit/CoverUnreached.h"

#include "Core/Fit/Initialise.h"
#include "Core/Image/Region.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

constexpr double kLeastContrast = 0.02; // smallest share of the intensity range that is worth a Gaussian

} // namespace

bool coverUnreached(GaussianField& field, std::span<const Stack> stacks, std::int64_t most,
                    RenderOptions options) {
  const std::vector<float> ones(field.gaussians.size(), 1.f);
  options.bounded = false;
  options.values = ones;
  std::vector<Gaussian> added;
  for (const Stack& stack : stacks) {
    if (!stack.poses.empty()) continue;
    const GridGeometry& g = stack.image.geometry;
    const auto observed = filledBlock(g.size, stack.observed);
    if (!observed) continue;
    const auto& [first, size] = *observed;
    const GridGeometry block = cropped(g, first, size);
    const Volume reached = render(field, block, options); // W / (W + ε): 0 where no Gaussian reaches
    const Affine3 toModel = inverse(field.modelToWorld) * block.indexToWorld();
    const double spacing = *std::min_element(g.spacing.begin(), g.spacing.end());
    for (std::int64_t n = 0; n < block.voxelCount(); ++n) {
      if (reached.voxels[n] > 0.5f) continue;
      const std::int64_t i = n % size[0], j = n / size[0] % size[1], k = n / (size[0] * size[1]);
      const std::int64_t v = first[0] + i + g.size[0] * (first[1] + j + g.size[1] * (first[2] + k));
      const float value = stack.image.voxels[v];
      if (!stack.observed[v] || !std::isfinite(value)) continue;
      // What nothing reaches is rendered as the offset.
      const double intensity = (value - field.intensityOffset) / field.intensityScale;
      if (std::abs(intensity) < kLeastContrast) continue;
      const Vec3 at = toModel({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      Gaussian gaussian{};
      for (int a = 0; a < 3; ++a) {
        gaussian.mean[a] = static_cast<float>(at[a]);
        gaussian.logScale[a] = static_cast<float>(std::log(0.95 * spacing / field.cutoff));
      }
      gaussian.quaternion[0] = 1;
      gaussian.intensity = static_cast<float>(intensity);
      added.push_back(gaussian);
    }
  }
  if (added.empty()) return false;
  if (static_cast<std::int64_t>(added.size()) > most) {
    std::stable_sort(added.begin(), added.end(), [](const Gaussian& a, const Gaussian& b) {
      return std::abs(a.intensity) > std::abs(b.intensity);
    });
    added.resize(static_cast<std::size_t>(most));
  }
  field.gaussians.insert(field.gaussians.end(), added.begin(), added.end());
  field.gaussians = inMortonOrder(std::move(field.gaussians));
  return true;
}

} // namespace innergs
