#pragma once
#include "Core/Base/Error.h"
#include "Cuda/Executor.h"
#ifdef INNERGS_TEST_CUDA
#include "Cuda/CudaExecutor.h"
#endif

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <vector>

namespace innergs::testing {

/// Where the kernels run in a test. Rounding: on the host with other last bits (RoundingExecutor.h), for
/// what must not hang on them.
enum class Where { Host, Rounding, Device };
inline const Where kEverywhere[] = {Where::Host, Where::Rounding, Where::Device};

inline std::string whereName(Where where) {
  return where == Where::Host ? "Host" : where == Where::Rounding ? "Rounding" : "Device";
}

/// Kernels on the host with real threads (ThreadBlock.h).
std::unique_ptr<cuda::Executor> makeThreadExecutor();
std::unique_ptr<cuda::Executor> makeRoundingExecutor();

/// Null with the reason when there is no device.
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

/// Euclidean length of the differences as a share of that of `expected`. Where weights are next to 0 the
/// last bit of one point can be seen in its quotient, so this is what devices that round otherwise are held
/// to.
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

/// The largest of the differences on the host, their length elsewhere.
inline double errorOn(Where where, std::span<const float> found, std::span<const float> expected,
                      std::size_t first = 0, std::size_t step = 1) {
  return where == Where::Host ? relativeError(found, expected, first, step)
                              : relativeLength(found, expected, first, step);
}

} // namespace innergs::testing
