#pragma once
#include "Cuda/Block.h"

namespace innergs::cuda {

/// A block of threads on the device: every thread runs the kernel, a phase is its own part.
template <int threads, class Shared>
class DeviceBlock {
public:
  template <class T>
  class PerThread {
  public:
    __device__ T& operator[](int) { return value_; }
    __device__ const T& operator[](int) const { return value_; }

  private:
    T value_;
  };

  __device__ explicit DeviceBlock(Shared& shared) : shared_(shared) {}

  __device__ std::int64_t index() const { return blockIdx.x; }
  __device__ Shared& shared() { return shared_; }
  __device__ void sync() { __syncthreads(); }

  template <class Phase>
  __device__ __forceinline__ void forEachThread(Phase&& phase) {
    phase(static_cast<int>(threadIdx.x));
  }

  template <class T, int n>
  __device__ __forceinline__ void warpSum(PerThread<Lanes<T, n>>& x) {
    T* v = x[0].v;
#pragma unroll
    for (int step = kWarp / 2; step > 0; step /= 2)
#pragma unroll
      for (int c = 0; c < n; ++c)
        v[c] += __shfl_xor_sync(0xffffffffu, v[c], step);
  }

  template <class T, int n>
  __device__ __forceinline__ void warpSum(PerThread<Lanes<T, n>>& x, const PerThread<bool>& active) {
    if (active[0]) warpSum(x);
  }

  __device__ __forceinline__ void ballot(const PerThread<bool>& x, PerThread<std::uint32_t>& mask) {
    mask[0] = __ballot_sync(0xffffffffu, x[0]);
  }

private:
  Shared& shared_;
};

template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads) runKernel(const Kernel kernel) {
  __shared__ typename Kernel::Shared shared;
  DeviceBlock<Kernel::kThreads, typename Kernel::Shared> block(shared);
  kernel(block);
}

} // namespace innergs::cuda
