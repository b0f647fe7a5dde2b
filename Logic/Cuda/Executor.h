#pragma once
#include "Cuda/Kernels.h"

#include <cstddef>
#include <memory>
#include <string>

namespace innergs::cuda {

template <class Kernel>
class Launches {
public:
  virtual void launch(const Kernel& kernel, std::int64_t blocks) = 0;

protected:
  ~Launches() = default;
};

template <class List>
class LaunchesAll;
template <class... Kernels>
class LaunchesAll<KernelList<Kernels...>> : public Launches<Kernels>... {
public:
  using Launches<Kernels>::launch...;

protected:
  ~LaunchesAll() = default;
};

/// Runs kernels: on a device, or on the host with the same blocks and threads. All work is queued in order;
/// only download() waits. Device errors are thrown as Error, lack of memory as Error(Memory).
class Executor : public LaunchesAll<AllKernels> {
public:
  virtual ~Executor() = default;
  virtual std::string name() const = 0;
  /// Bytes still available to allocate().
  virtual std::size_t freeBytes() = 0;

  virtual void* allocate(std::size_t bytes) = 0;
  virtual void release(void* memory) noexcept = 0;
  virtual void upload(void* to, const void* from, std::size_t bytes) = 0; // `from` may change afterwards
  virtual void download(void* to, const void* from, std::size_t bytes) = 0;
  virtual void fill(void* memory, int byte, std::size_t bytes) = 0;

  /// out[i] = Σ_{j<i} in[j].
  virtual void scan(const std::int64_t* in, std::int64_t* out, std::int64_t count) = 0;
  /// Reserves what scan() and sort() of that many need: they then cannot run out of memory.
  virtual void prepareSort(std::int64_t count, int bits) = 0;
  /// Stable sort by the lowest `bits` bits of the keys. Afterwards `keys` and `ids` hold the sorted pairs;
  /// they may have been swapped with the other two.
  virtual void sort(std::uint64_t*& keys, std::uint64_t*& otherKeys, std::uint32_t*& ids,
                    std::uint32_t*& otherIds, std::int64_t count, int bits) = 0;

  template <class Kernel>
  void run(const Kernel& kernel, std::int64_t blocks) {
    if (blocks > 0) launch(kernel, blocks);
  }
  /// Runs one thread per item.
  template <class Kernel>
  void runOver(const Kernel& kernel, std::int64_t items) {
    run(kernel, blocksFor(items, Kernel::kThreads));
  }
};

} // namespace innergs::cuda
