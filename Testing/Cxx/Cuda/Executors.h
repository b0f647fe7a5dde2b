#pragma once
#include "Core/Error.h"
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

/// Where the kernels run in a test.
enum class Where { Host, Device };
inline const Where kEverywhere[] = {Where::Host, Where::Device};

inline std::string whereName(Where where) {
  return where == Where::Host ? "Host" : "Device";
}

/// Kernels on the host with real threads (ThreadBlock.h).
std::unique_ptr<cuda::Executor> makeThreadExecutor();

/// Null with the reason when there is no device.
inline std::unique_ptr<cuda::Executor> executorFor(Where where, std::string& why) {
  if (where == Where::Host) return cuda::makeHostExecutor();
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

} // namespace innergs::testing
