#pragma once
#include "Core/Device/Devices.h"
#include "Core/Fit/FitDevice.h"
#include "Core/Render/Kernels.h"

#include <memory>
#include <span>
#include <vector>

namespace innergs {

/// The error of fields on the frames of a dynamic scan, and its gradient: on a device or, without one or once
/// it fails, on the CPU.
class FrameLoss {
public:
  /// frames: all on one grid. device: used from the first call on; null: the CPU. Kernels, pool and device
  /// must outlive this.
  FrameLoss(std::vector<Observation> frames, const KernelSet& kernels, ThreadPool& pool,
            DeviceChoice* device);

  const Observation& frame(std::int64_t index) const { return (*request_.observations)[index]; }

  /// Mean squared error (normalised intensity²) of a field on a frame. gradient, if not empty, becomes that
  /// of the squared loss (Loss.h) with respect to the field's Gaussians, 16 floats each. Throws
  /// Error(Cancelled) when the pool is stopped.
  double operator()(const GaussianField& field, std::int64_t frame, std::span<float> gradient = {});

private:
  void place(const GaussianField& field);

  FitRequest request_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  DeviceChoice* choice_;
  std::unique_ptr<FitDevice> device_; // null before the first call
  bool onCpu_ = false;
};

} // namespace innergs
