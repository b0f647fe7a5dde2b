#pragma once
#include "Core/Acquisition/ClosedFormPsf.h"
#include "Core/Acquisition/SampleGrid.h"

#include <span>
#include <stop_token>

namespace innergs {

/// A field stored on a device for rendering. Values are I in the field's own units: without residual grid,
/// domain and intensity map. `values`: one per Gaussian, replaces intensity and slope if not empty. Throws
/// Error(Memory) if device memory runs out, Error(Cancelled) when stopped.
class FieldDevice {
public:
  virtual ~FieldDevice() = default;
  /// Renders a grid, with a closed-form profile if psf.active. Alpha blending: each plane has its own
  /// depth order. out: [plane][ny][nx], host memory.
  virtual void renderGrid(const SampleGrid& grid, const ClosedFormPsf& psf, std::span<const float> values,
                          float* out, std::stop_token stop) = 0;
  /// Renders points of the model frame (mm). Alpha blending: on slices normal to the model's third axis.
  virtual void renderPoints(std::span<const Vec3> points, std::span<const float> values, float* out,
                            std::stop_token stop) = 0;
};

} // namespace innergs
