#pragma once
#include "Cuda/CudaLaunch.h"
#include "Cuda/DeviceBlock.cuh"

namespace innergs::cuda {

template <class Kernel>
cudaError_t launchOnDevice(const Kernel& kernel, unsigned blocks, cudaStream_t stream) {
  runKernel<<<blocks, Kernel::kThreads, 0, stream>>>(kernel);
  return cudaGetLastError();
}

} // namespace innergs::cuda

#define INNERGS_LAUNCH(...)                                                                                  \
  template cudaError_t innergs::cuda::launchOnDevice(const __VA_ARGS__&, unsigned, cudaStream_t)
