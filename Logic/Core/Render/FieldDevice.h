#pragma once
#include "Core/Acquisition/ClosedFormPsf.h"
#include "Core/Acquisition/Lattice.h"

#include <span>
#include <stop_token>

namespace innergs {

/// A field kept on a device to be looked at. Values are I in the field's own units: without residual grid,
/// domain, intensity map. `values`: one per Gaussian, replaces intensity and slope when not empty. Out of
/// device memory: Error(Memory); stopped: Error(Cancelled).
class FieldDevice {
public:
  virtual ~FieldDevice() = default;
  /// At the points of a lattice, seen through a closed-form profile where psf.active. Alpha blending: each
  /// plane in its own depth order. out: [plane][ny][nx], host memory.
  virtual void renderLattice(const Lattice& lattice, const ClosedFormPsf& psf, std::span<const float> values,
                             float* out, std::stop_token stop) = 0;
  /// At points of the model frame (mm). Alpha blending: each on a slice across the model's third axis.
  virtual void renderPoints(std::span<const Vec3> points, std::span<const float> values, float* out,
                            std::stop_token stop) = 0;
};

} // namespace innergs
