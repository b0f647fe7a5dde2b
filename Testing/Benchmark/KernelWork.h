#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Model/GaussianField.h"
#include "Cuda/Executor.h"

namespace innergs::bench {

/// The work of the two heaviest kernels for one field on one grid, counted on the host.
struct KernelWork {
  double evaluations = 0;  // points within the ellipsoids, which any method must compute
  double flops = 0;        // minimum for them
  double bytes = 0;        // minimum read and written
  double instructions = 0; // of warps, from the instructions counted in the SASS for sm_90 (nvcc 13.0)
};

/// Accumulate and Gather, ready to run separately.
class HeavyKernels {
public:
  HeavyKernels(cuda::Executor& executor, const GaussianField& field, const Observation& observation);
  ~HeavyKernels();

  void accumulate();
  void gather();
  KernelWork accumulateWork, gatherWork;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace innergs::bench
