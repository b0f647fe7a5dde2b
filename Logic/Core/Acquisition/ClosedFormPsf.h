#pragma once

namespace innergs {

/// The observation kernel of a slice in closed form (additive blending): a covariance (model frame, mm²; xx
/// xy xz yy yz zz) that is added to every Gaussian's.
struct ClosedFormPsf {
  bool active = false;
  float covariance[6] = {};
};

} // namespace innergs
