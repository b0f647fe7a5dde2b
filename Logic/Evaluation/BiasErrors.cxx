#include "Evaluation/BiasErrors.h"

#include <cmath>

namespace innergs {

BiasErrors biasErrors(const BiasCorrection& found, std::span<const StackAlignment> alignment,
                      std::span<const std::function<double(const Vec3&)>> truth, const Mask& body) {
  constexpr std::size_t every = 7;
  const std::size_t stacks = truth.size();
  const auto& n = body.geometry.size;
  const Affine3 map = body.geometry.indexToWorld();
  std::vector<double> errors, mean(stacks);
  for (std::size_t v = 0; v < body.voxels.size(); v += every) {
    if (!body.voxels[v]) continue;
    const auto at = static_cast<std::int64_t>(v);
    const Vec3 x = map({static_cast<double>(at % n[0]), static_cast<double>(at / n[0] % n[1]),
                        static_cast<double>(at / (n[0] * n[1]))});
    for (std::size_t s = 0; s < stacks; ++s) {
      const Vec3 moved = alignment.empty() ? x : alignment[s].toOthers(x);
      const double own = found.scans.empty() ? 0 : found.scans[s].field.logAt(moved);
      errors.push_back(own - std::log(truth[s](x)));
      mean[s] += errors.back();
    }
  }
  BiasErrors result;
  const auto places = static_cast<double>(errors.size() / stacks);
  for (std::size_t p = 0; p < errors.size(); p += stacks) {
    double shared = 0;
    for (std::size_t s = 0; s < stacks; ++s)
      shared += (errors[p + s] - mean[s] / places) / static_cast<double>(stacks);
    result.shared += shared * shared;
    for (std::size_t s = 0; s < stacks; ++s) {
      const double own = errors[p + s] - mean[s] / places - shared;
      result.between += own * own / static_cast<double>(stacks);
    }
  }
  result.shared = std::sqrt(result.shared / places);
  result.between = std::sqrt(result.between / places);
  return result;
}

} // namespace innergs
