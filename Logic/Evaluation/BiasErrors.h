#pragma once
#include "Core/Alignment/BiasCorrection.h"

#include <functional>

namespace innergs {

/// Errors of the logarithm of the found shading: root mean squares in the body, after removing one gain per
/// stack. 0.01: 1 % of the brightness.
struct BiasErrors {
  double between = 0; // how far stacks still differ from their mean
  double shared = 0;  // that mean, which is in the result
};

/// truth: per stack, the factor of its brightness at a point, LPS mm. alignment: of the stacks; empty: they
/// were not moved. Fields without coefficients: nothing was corrected.
BiasErrors biasErrors(const BiasCorrection& found, std::span<const StackAlignment> alignment,
                      std::span<const std::function<double(const Vec3&)>> truth, const Mask& body);

} // namespace innergs
