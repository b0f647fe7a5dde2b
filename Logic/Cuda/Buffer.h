#pragma once
#include "Cuda/Executor.h"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace innergs::cuda {

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
