#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Cuda/Executor.h"

#include <functional>

namespace innergs::cuda {

/// The CUDA devices of this machine, or the reason why there are none. Never throws, and starts no device, so
/// free memory is unknown.
DeviceList cudaDevices();

/// Bytes. Throws Error if the device cannot be used.
std::int64_t cudaFreeMemory(int device);

/// Device properties that benchmarks compare their figures with. Throws Error like cudaFreeMemory().
struct CudaFacts {
  int driver = 0, runtime = 0;            // CUDA versions, 1000·major + 10·minor
  int processors = 0, lanes = 0;          // multiprocessors, and single-precision units of each
  double hertz = 0, bytesPerSecond = 0;   // highest clock; memory bandwidth computed from the memory's clock
  std::int64_t memory = 0, free = 0;      // bytes, in total and now
  std::int64_t reserved = 0, highest = 0; // bytes held for executors: now, and the most since the last call
};
CudaFacts cudaFacts(int device);

/// Seconds that the device takes for the work that `queued` queues on an executor of makeCudaExecutor(),
/// measured by its own events; waits for it.
double cudaSeconds(Executor& executor, const std::function<void()>& queued);

/// Throws Error if there is no such device or it cannot be used.
std::unique_ptr<Executor> makeCudaExecutor(int device);

} // namespace innergs::cuda
