#pragma once
#include "Core/DevicePlugin.h"
#include "Cuda/Executor.h"

namespace innergs::cuda {

/// The CUDA devices of this machine, or why there are none. Never throws, and
/// starts none: their free memory is not looked at.
DeviceList cudaDevices();

/// Bytes. Throws Error when the device cannot be used.
std::int64_t cudaFreeMemory(int device);

/// Throws Error when there is no such device or it cannot be used.
std::unique_ptr<Executor> makeCudaExecutor(int device);

} // namespace innergs::cuda
