#pragma once
#include "Core/Model/GaussianMath.h"

#include <cstdint>
#include <cstring>
#include <type_traits>

/// A kernel is a struct of pointers and numbers with kThreads, a type Shared (trivial, in shared memory) and
///
///   template <class Block> INNERGS_KERNEL void operator()(Block& block) const;
///
/// written as phases over the threads of one block. The same code runs on the host (HostBlock.h: loops over
/// the threads of a phase) and on the device (DeviceBlock.cuh). A Block offers
///
///   index()                      number of the block
///   shared()                     its Shared
///   PerThread<T> x; x[t]         a register that lives from phase to phase
///   forEachThread(f)             f(thread): one phase; control flow around it must be uniform
///   sync()                       separates a phase that writes shared memory from one that reads it
///   warpSum(x)                   x: PerThread<Lanes<T, n>>; every lane gets its warp's sums, added in the
///                                same order
///   warpShare(x, own)            x: PerThread<Lanes<float, n>>, n a power of 2, destroyed; own:
///                                PerThread<float>: lane l gets its warp's sum number l·n/32, with fewer
///                                shuffles
///   warpShare(x, own, active)    only in warps whose lanes are all active (PerThread<bool>); else 0
///   ballot(x, mask)              x: PerThread<bool>, mask: PerThread<std::uint32_t> of its warp
#if defined(__CUDACC__)
#define INNERGS_KERNEL __device__ __forceinline__
#define INNERGS_UNROLL _Pragma("unroll")
#else
#define INNERGS_KERNEL
#define INNERGS_UNROLL // arrays indexed by the loop stay in registers
#endif

namespace innergs::cuda {

constexpr int kWarp = 32;

/// Several sums held by one thread.
template <class T, int n>
struct Lanes {
  static constexpr int size = n;
  T v[n];
};

/// For kernels without shared memory.
struct Nothing {};

/// W and N of a point (alpha blending: transmittance and I), later F0 and F1 (Docs/method.md).
struct alignas(8) Pair {
  float a, b;
};

/// Sixteen floats of a Gaussian: its gradient, or a moment of Adam.
struct Record {
  float v[16];
};
INNERGS_HD inline Record* recordsAt(float* first) {
  return reinterpret_cast<Record*>(first);
}
INNERGS_HD inline const Record* recordsAt(const float* first) {
  return reinterpret_cast<const Record*>(first);
}

/// *from and *to = x, with accesses as wide as the size of T allows. On the device, arrays of T must start at
/// a multiple of 16 bytes.
template <class T>
INNERGS_HD inline T loaded(const T* from) {
  T out;
#if defined(__CUDA_ARCH__)
  using Part = std::conditional_t<sizeof(T) % sizeof(float4) == 0, float4, float2>;
  static_assert(sizeof(T) % sizeof(Part) == 0);
  Part parts[sizeof(T) / sizeof(Part)];
#pragma unroll
  for (unsigned i = 0; i < sizeof(T) / sizeof(Part); ++i)
    parts[i] = reinterpret_cast<const Part*>(from)[i];
  memcpy(&out, parts, sizeof out);
#else
  std::memcpy(&out, from, sizeof out);
#endif
  return out;
}
template <class T>
INNERGS_HD inline void stored(T* to, const T& x) {
#if defined(__CUDA_ARCH__)
  using Part = std::conditional_t<sizeof(T) % sizeof(float4) == 0, float4, float2>;
  Part parts[sizeof(T) / sizeof(Part)];
  memcpy(parts, &x, sizeof x);
#pragma unroll
  for (unsigned i = 0; i < sizeof(T) / sizeof(Part); ++i)
    reinterpret_cast<Part*>(to)[i] = parts[i];
#else
  std::memcpy(to, &x, sizeof x);
#endif
}

/// a / b for non-negative numbers: 64-bit divisions take several times as long on a device.
INNERGS_HD inline std::int64_t quotient(std::int64_t a, std::int64_t b) {
  if (((a | b) >> 31) == 0) return static_cast<std::int32_t>(a) / static_cast<std::int32_t>(b);
  return a / b;
}

/// Position of the lowest set bit.
INNERGS_HD inline int lowestBit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  int n = 0;
  for (; !(bits & 1); bits >>= 1)
    ++n;
  return n;
#endif
}

/// One thread per item: each(i) for i < count, over all blocks.
template <int threads, class Block, class Each>
INNERGS_KERNEL void forEachItem(Block& block, std::int64_t count, Each&& each) {
  block.forEachThread([&](int t) {
    const std::int64_t i = block.index() * threads + t;
    if (i < count) each(i);
  });
}

constexpr std::int64_t blocksFor(std::int64_t items, int perBlock) {
  return (items + perBlock - 1) / perBlock;
}

} // namespace innergs::cuda
