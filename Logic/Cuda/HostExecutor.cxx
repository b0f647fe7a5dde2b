#include "Core/Error.h"
#include "Cuda/Executor.h"
#include "Cuda/HostBlock.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

namespace innergs::cuda {
namespace {

template <class Base, class... Kernels>
class HostLaunches;

template <class Base>
class HostLaunches<Base> : public Base {};

template <class Base, class Kernel, class... Others>
class HostLaunches<Base, Kernel, Others...> : public HostLaunches<Base, Others...> {
public:
  void launch(const Kernel& kernel, std::int64_t blocks) override {
    const auto shared = std::make_unique<typename Kernel::Shared>();
    for (std::int64_t i = 0; i < blocks; ++i) {
      HostBlock<Kernel::kThreads, typename Kernel::Shared> block(i, *shared);
      kernel(block);
    }
  }
};

template <class List>
struct HostBase;
template <class... Kernels>
struct HostBase<KernelList<Kernels...>> {
  using Type = HostLaunches<Executor, Kernels...>;
};

class HostExecutor final : public HostBase<AllKernels>::Type {
public:
  explicit HostExecutor(std::size_t memory) : free_(memory) {}

  std::string name() const override { return "host"; }
  std::size_t freeBytes() override { return free_; }

  void* allocate(std::size_t bytes) override {
    const bool injected = toFailure_ > 0 ? --toFailure_ == 0 : failing_ > 0;
    if (injected && failing_ > 0) --failing_;
    if (injected || bytes > free_)
      throw Error(ErrorCode::Memory, "The device's memory is full: use fewer Gaussians or the CPU.");
    auto memory = std::make_unique<std::byte[]>(bytes);
    std::memset(memory.get(), 0xcd, bytes); // as little initialised as a device's
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
  void download(void* to, const void* from, std::size_t bytes) override { std::memcpy(to, from, bytes); }
  void fill(void* memory, int byte, std::size_t bytes) override { std::memset(memory, byte, bytes); }

  void scan(const std::int64_t* in, std::int64_t* out, std::int64_t count) override {
    std::exclusive_scan(in, in + count, out, std::int64_t{0});
  }
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

  int toFailure_ = 0, failing_ = 0;

private:
  struct Memory {
    std::unique_ptr<std::byte[]> data;
    std::size_t bytes;
  };
  std::map<void*, Memory> blocks_;
  std::size_t free_;
};

} // namespace

std::unique_ptr<Executor> makeHostExecutor(std::size_t memory) {
  return std::make_unique<HostExecutor>(memory);
}

void failAllocations(Executor& host, int nth, int count) {
  auto& executor = dynamic_cast<HostExecutor&>(host);
  executor.toFailure_ = nth;
  executor.failing_ = count;
}

int allocationsToFailure(const Executor& host) {
  return dynamic_cast<const HostExecutor&>(host).toFailure_;
}

} // namespace innergs::cuda
