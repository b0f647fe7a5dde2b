#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <optional>

namespace innergs {

/// σ² (mm²) with which a linearly interpolated stack shows tissue along its axis 0, 1 or 2.
double resolutionVariance(const Stack& stack, int axis);
/// The largest of those σ (mm), of any axis of the stacks in `part`.
double commonResolution(std::span<const Stack> stacks, std::span<const std::size_t> part);

/// A stack, blurred so that it shows tissue with the same σ in all directions, for reading at any point.
class BlurredStack {
public:
  /// sigma: mm, at least that of the stack's coarsest axis. Ignores unobserved and non-finite voxels.
  /// Throws Error(Cancelled).
  BlurredStack(const Stack& stack, double sigma, ThreadPool& pool);

  /// The value at x (LPS mm of the stack itself); nothing where too little was observed.
  std::optional<double> at(const Vec3& x) const;

  const GridGeometry& geometry() const { return geometry_; }
  std::span<const float> values() const { return value_; } // NaN: unobserved

private:
  GridGeometry geometry_;
  Affine3 worldToIndex_;
  std::vector<float> value_;
};

} // namespace innergs
