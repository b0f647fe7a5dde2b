#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Cuda/Passes.h"

namespace innergs::cuda {

/// A field stored where an executor runs. Large grids are processed in slabs of planes.
class Field final : public FieldDevice {
public:
  Field(std::unique_ptr<Executor> executor, const GaussianField& field);

  void renderGrid(const SampleGrid& grid, const ClosedFormPsf& psf, std::span<const float> values, float* out,
                  std::stop_token stop) override;
  void renderPoints(std::span<const Vec3> points, std::span<const float> values, float* out,
                    std::stop_token stop) override;

private:
  const float* upload(std::span<const float> values);
  /// renderPoints() with cells of that edge (mm); channel: device memory.
  void answer(std::span<const Vec3> points, const float* channel, const Vec3& low, const Vec3& high,
              double cell, float* out, const std::stop_token& stop);
  ProjectionRules rules(const ClosedFormPsf& psf) const;

  std::unique_ptr<Executor> executor_;
  GaussianField numbers_; // without Gaussians and residual grid
  std::int64_t count_;
  Passes passes_;
  Buffer<Gaussian> gaussians_;
  Buffer<float> values_, result_;
  Buffer<double> points_;
};

} // namespace innergs::cuda
