#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <optional>

namespace innergs {

/// σ² in mm² with which a stack, interpolated linearly, shows tissue along its axis 0, 1 or 2.
double resolutionVariance(const Stack& stack, int axis);

/// A stack blurred so that it shows tissue with one σ in all directions, to be read at any place.
class BlurredStack {
public:
  /// sigma: mm, at least that of the stack's coarsest axis. Unobserved and non-finite voxels count for
  /// nothing. Throws Error(Cancelled).
  BlurredStack(const Stack& stack, double sigma, ThreadPool& pool);

  /// At x (LPS mm of the stack itself); none where too little was observed.
  std::optional<double> at(const Vec3& x) const;

  const GridGeometry& geometry() const { return geometry_; }
  std::span<const float> values() const { return value_; } // NaN: unobserved

private:
  GridGeometry geometry_;
  Affine3 worldToIndex_;
  std::vector<float> value_;
};

} // namespace innergs
