#pragma once
#include "Cuda/Block.h"

namespace innergs::cuda {

/// A block of threads on the device: every thread runs the kernel and its own part of each phase.
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

  /// Each step halves the sums that a lane keeps and passes the other half to its partner.
  template <int n>
  __device__ __forceinline__ void warpShare(PerThread<Lanes<float, n>>& x, PerThread<float>& own) {
    static_assert(n >= 1 && n <= kWarp && (n & (n - 1)) == 0);
    float* v = x[0].v;
    halve<n / 2, n>(v);
#pragma unroll
    for (int step = kWarp / n / 2; step > 0; step /= 2)
      v[0] += __shfl_xor_sync(0xffffffffu, v[0], step);
    own[0] = v[0];
  }

  template <int n>
  __device__ __forceinline__ void warpShare(PerThread<Lanes<float, n>>& x, PerThread<float>& own,
                                            const PerThread<bool>& active) {
    own[0] = 0;
    if (active[0]) warpShare(x, own);
  }

  __device__ __forceinline__ void ballot(const PerThread<bool>& x, PerThread<std::uint32_t>& mask) {
    mask[0] = __ballot_sync(0xffffffffu, x[0]);
  }

private:
  /// Recursive, so that v stays in registers.
  template <int width, int n>
  __device__ __forceinline__ void halve(float* v) {
    if constexpr (width > 0) {
      constexpr int step = kWarp * width / n;
      const bool upper = (threadIdx.x & step) != 0;
#pragma unroll
      for (int c = 0; c < width; ++c) {
        const float sent = upper ? v[c] : v[c + width];
        v[c] = (upper ? v[c + width] : v[c]) + __shfl_xor_sync(0xffffffffu, sent, step);
      }
      halve<width / 2, n>(v);
    }
  }

  Shared& shared_;
};

template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads) runKernel(const Kernel kernel) {
  __shared__ typename Kernel::Shared shared;
  DeviceBlock<Kernel::kThreads, typename Kernel::Shared> block(shared);
  kernel(block);
}

} // namespace innergs::cuda
