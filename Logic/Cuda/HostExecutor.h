#pragma once
#include "Core/Base/Error.h"
#include "Cuda/Executor.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

namespace innergs::cuda {

/// The host executor without the kernels.
class HostMemory : public Executor {
public:
  explicit HostMemory(std::size_t memory) : free_(memory) {}

  std::string name() const override { return "host"; }
  std::size_t freeBytes() override { return free_; }

  void* allocate(std::size_t bytes) override {
    const bool injected = toFailure_ > 0 ? --toFailure_ == 0 : failing_ > 0;
    if (injected && failing_ > 0) --failing_;
    if (injected || bytes > free_)
      throw Error(ErrorCode::Memory, "The device's memory is full: use fewer Gaussians or the CPU.");
    auto memory = std::make_unique<std::byte[]>(bytes);
    std::memset(memory.get(), 0xcd, bytes); // uninitialised, as on a device
    std::byte* raw = memory.get();
    blocks_[raw] = {std::move(memory), bytes};
    free_ -= bytes;
    return raw;
  }
  void release(void* memory) noexcept override {
    const auto at = blocks_.find(memory);
    if (at == blocks_.end()) return;
    free_ += at->second.bytes;
    blocks_.erase(at);
  }
  void upload(void* to, const void* from, std::size_t bytes) override { std::memcpy(to, from, bytes); }
  void download(void* to, const void* from, std::size_t bytes) override {
    ++downloads_;
    std::memcpy(to, from, bytes);
  }
  void fill(void* memory, int byte, std::size_t bytes) override { std::memset(memory, byte, bytes); }

  void scan(const std::int64_t* in, std::int64_t* out, std::int64_t count) override {
    std::exclusive_scan(in, in + count, out, std::int64_t{0}, [](std::int64_t a, std::int64_t b) {
      return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
    }); // wraps around like a device, on what a faulty kernel left
  }
  void prepareSort(std::int64_t, int) override {}
  void sort(std::uint64_t*& keys, std::uint64_t*& otherKeys, std::uint32_t*& ids, std::uint32_t*& otherIds,
            std::int64_t count, int bits) override {
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    std::vector<std::int64_t> order(count);
    std::iota(order.begin(), order.end(), std::int64_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return (keys[a] & mask) < (keys[b] & mask); });
    for (std::int64_t i = 0; i < count; ++i) {
      otherKeys[i] = keys[order[i]];
      otherIds[i] = ids[order[i]];
    }
    std::swap(keys, otherKeys);
    std::swap(ids, otherIds);
  }

  int toFailure_ = 0, failing_ = 0, downloads_ = 0;

private:
  struct Memory {
    std::unique_ptr<std::byte[]> data;
    std::size_t bytes;
  };
  std::map<void*, Memory> blocks_;
  std::size_t free_;
};

template <class Runner, class Base, class... Kernels>
class HostLaunches;

template <class Runner, class Base>
class HostLaunches<Runner, Base> : public Base {
public:
  using Base::Base;
};

template <class Runner, class Base, class Kernel, class... Others>
class HostLaunches<Runner, Base, Kernel, Others...> : public HostLaunches<Runner, Base, Others...> {
public:
  using HostLaunches<Runner, Base, Others...>::HostLaunches;
  void launch(const Kernel& kernel, std::int64_t blocks) override { Runner::run(kernel, blocks); }
};

template <class Runner, class List>
struct HostBase;
template <class Runner, class... Kernels>
struct HostBase<Runner, KernelList<Kernels...>> {
  using Type = HostLaunches<Runner, HostMemory, Kernels...>;
};

/// Runner::run(kernel, blocks) runs the kernels.
template <class Runner>
class HostExecutor final : public HostBase<Runner, AllKernels>::Type {
public:
  using HostBase<Runner, AllKernels>::Type::Type;
};

/// Runs kernels as plain loops on the host, with the device's blocks and threads: for tests without one.
/// memory: total bytes to allow.
std::unique_ptr<Executor> makeHostExecutor(std::size_t memory = std::size_t{1} << 40);
/// For tests: makes the n-th allocation from now on fail, `count` in a row; 0: none.
void failAllocations(Executor& host, int nth, int count);
/// Allocations left until that failure; 0: it has happened.
int allocationsToFailure(const Executor& host);
/// The number of downloads, i.e. how often a device would have been waited for.
int downloads(const Executor& host);

} // namespace innergs::cuda
