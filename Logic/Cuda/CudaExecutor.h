#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Cuda/Executor.h"

#include <functional>

namespace innergs::cuda {

/// The CUDA devices of this machine, or why there are none. Never throws, and
/// starts none: their free memory is not looked at.
DeviceList cudaDevices();

/// Bytes. Throws Error when the device cannot be used.
std::int64_t cudaFreeMemory(int device);

/// What benchmarks set their figures against. Throws Error as cudaFreeMemory().
struct CudaFacts {
  int driver = 0, runtime = 0;            // CUDA versions, 1000·major + 10·minor
  int processors = 0, lanes = 0;          // multiprocessors, and single-precision units of each
  double hertz = 0, bytesPerSecond = 0;   // the highest clock, and of the memory what follows from its clock
  std::int64_t memory = 0, free = 0;      // bytes, of the device and now
  std::int64_t reserved = 0, highest = 0; // bytes held for executors: now, and the most since the last call
};
CudaFacts cudaFacts(int device);

/// Seconds that the device takes for what `queued` queues on that executor of makeCudaExecutor(), by its own
/// events; waits for it.
double cudaSeconds(Executor& executor, const std::function<void()>& queued);

/// Throws Error when there is no such device or it cannot be used.
std::unique_ptr<Executor> makeCudaExecutor(int device);

} // namespace innergs::cuda
