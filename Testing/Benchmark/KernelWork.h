#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Model/GaussianField.h"
#include "Cuda/Executor.h"

namespace innergs::bench {

/// What the two heaviest kernels have to do for one field on one lattice, counted on the host.
struct KernelWork {
  double evaluations = 0;  // points within the ellipsoids: what any method must compute
  double flops = 0;        // for them, at least
  double bytes = 0;        // read and written at least
  double instructions = 0; // of warps, by the instructions counted in the SASS of sm_90 (nvcc 13.0)
};

/// Accumulate and Gather ready to be run by themselves.
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
