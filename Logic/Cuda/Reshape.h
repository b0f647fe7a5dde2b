#pragma once
#include "Core/Densify.h"
#include "Core/Relocate.h"
#include "Cuda/Executor.h"

namespace innergs::cuda {

/// What a fit holds where an executor runs. Gaussians are kept as the 16 floats that they are, so that one
/// kernel reorders them and their moments.
struct FitBuffers {
  explicit FitBuffers(Executor& e) : gaussians(e), moment1(e), moment2(e), pulls(e) {}

  Gaussian* field() const { return reinterpret_cast<Gaussian*>(gaussians.data()); }
  /// Room for `size` at least; what they held is lost when they grow. All or nothing.
  void reserve(Executor& executor, std::int64_t size);

  std::int64_t count = 0;
  Buffer<float> gaussians, moment1, moment2; // 16 a Gaussian
  Buffer<float> pulls;
};

/// relocateGaussians() without leaving the device, and without waiting for it. spare: memory of a record a
/// Gaussian whose content does not matter. Error(Memory) leaves all as it was.
void relocate(Executor& executor, FitBuffers& fit, Buffer<float>& spare, const RelocationPlan& plan);

/// densifyGaussians() in the same way; waits for numbers of Gaussians, twice.
DensifyCounts densify(Executor& executor, FitBuffers& fit, Blending blending, int sweeps,
                      const DensifyPlan& plan);

} // namespace innergs::cuda
