#pragma once
#include "Core/Base/Error.h"
#include "Cuda/HostExecutor.h"
#ifdef INNERGS_TEST_CUDA
#include "Cuda/CudaExecutor.h"
#endif

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <vector>

namespace innergs::testing {

/// Where the kernels of a test run. Rounding: on the host with different last bits (RoundingExecutor.h), for
/// results that must not depend on them.
enum class Where { Host, Rounding, Device };
inline const Where kEverywhere[] = {Where::Host, Where::Rounding, Where::Device};

inline std::string whereName(Where where) {
  return where == Where::Host ? "Host" : where == Where::Rounding ? "Rounding" : "Device";
}

/// Kernels on the host with real threads (ThreadBlock.h).
std::unique_ptr<cuda::Executor> makeThreadExecutor();
std::unique_ptr<cuda::Executor> makeRoundingExecutor();

/// Null, with the reason, if there is no device.
inline std::unique_ptr<cuda::Executor> executorFor(Where where, std::string& why) {
  if (where == Where::Host) return cuda::makeHostExecutor();
  if (where == Where::Rounding) return makeRoundingExecutor();
#ifdef INNERGS_TEST_CUDA
  const DeviceList list = cuda::cudaDevices();
  if (!list.devices.empty()) return cuda::makeCudaExecutor(0);
  why = list.problem;
#else
  why = "Built without nvcc.";
#endif
  return nullptr;
}

#define INNERGS_EXECUTOR_OR_SKIP(executor, where)                                                            \
  std::string why;                                                                                           \
  std::unique_ptr<cuda::Executor> executor = executorFor(where, why);                                        \
  if (!executor) GTEST_SKIP() << "NOT RUN ON A DEVICE. " << why

/// Largest difference as a share of the largest magnitude.
inline double relativeError(std::span<const float> found, std::span<const float> expected,
                            std::size_t first = 0, std::size_t step = 1) {
  double largest = 0, difference = 0;
  for (std::size_t i = first; i < expected.size(); i += step) {
    if (!std::isfinite(found[i])) return HUGE_VAL;
    largest = std::max(largest, std::fabs(static_cast<double>(expected[i])));
    difference = std::max(difference, std::fabs(static_cast<double>(found[i]) - expected[i]));
  }
  return difference == 0 ? 0 : difference / std::max(largest, 1e-30);
}

/// Norm of the differences relative to that of `expected`. Where weights are near 0, the last bit of one
/// point is visible in its quotient, so this is the criterion for devices with different rounding.
inline double relativeLength(std::span<const float> found, std::span<const float> expected,
                             std::size_t first = 0, std::size_t step = 1) {
  double whole = 0, difference = 0;
  for (std::size_t i = first; i < expected.size(); i += step) {
    const double e = expected[i], d = static_cast<double>(found[i]) - e;
    if (!std::isfinite(d)) return HUGE_VAL;
    whole += e * e;
    difference += d * d;
  }
  return difference == 0 ? 0 : std::sqrt(difference / std::max(whole, 1e-60));
}

/// The largest difference on the host, the norm of the differences elsewhere.
inline double errorOn(Where where, std::span<const float> found, std::span<const float> expected,
                      std::size_t first = 0, std::size_t step = 1) {
  return where == Where::Host ? relativeError(found, expected, first, step)
                              : relativeLength(found, expected, first, step);
}

} // namespace innergs::testing
