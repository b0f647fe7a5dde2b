#pragma once
#include "Cuda/Kernels.h"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

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

/// An executor's array of a plain type; grows but never shrinks by itself.
template <class T>
class Buffer {
public:
  explicit Buffer(Executor& executor) : executor_(&executor) {}
  ~Buffer() { clear(); }
  Buffer(Buffer&& other) noexcept
      : executor_(other.executor_), data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(executor_, other.executor_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }

  T* data() const { return data_; }
  std::int64_t size() const { return size_; }
  /// At least `count` elements; the content is lost when it grows.
  T* reserve(std::int64_t count) {
    if (count <= size_) return data_;
    clear();
    data_ = static_cast<T*>(executor_->allocate(static_cast<std::size_t>(count) * sizeof(T)));
    size_ = count;
    return data_;
  }
  void upload(const T* from, std::int64_t count) {
    reserve(count);
    if (count > 0) executor_->upload(data_, from, static_cast<std::size_t>(count) * sizeof(T));
  }
  void download(T* to, std::int64_t count) const {
    if (count > 0) executor_->download(to, data_, static_cast<std::size_t>(count) * sizeof(T));
  }
  void fill(int byte, std::int64_t count) {
    if (count > 0) executor_->fill(data_, byte, static_cast<std::size_t>(count) * sizeof(T));
  }
  void clear() noexcept {
    if (data_) executor_->release(data_);
    data_ = nullptr;
    size_ = 0;
  }

private:
  Executor* executor_;
  T* data_ = nullptr;
  std::int64_t size_ = 0;
};

/// Executor::sort() of whole buffers, swapped together with their sizes.
inline void sortPairs(Executor& executor, Buffer<std::uint64_t>& keys, Buffer<std::uint64_t>& otherKeys,
                      Buffer<std::uint32_t>& ids, Buffer<std::uint32_t>& otherIds, std::int64_t count,
                      int bits) {
  std::uint64_t *key = keys.data(), *otherKey = otherKeys.data();
  std::uint32_t *id = ids.data(), *otherId = otherIds.data();
  if (count > 0) executor.sort(key, otherKey, id, otherId, count, bits);
  if (key != keys.data()) std::swap(keys, otherKeys);
  if (id != ids.data()) std::swap(ids, otherIds);
}

} // namespace innergs::cuda
