#pragma once
#include "Cuda/HostBlock.h"
#include "Cuda/HostExecutor.h"

#include <array>
#include <barrier>
#include <cstring>
#include <optional>
#include <thread>
#include <vector>

namespace innergs::testing {

/// State shared by the threads of a block, besides its Shared.
template <int threads>
struct ThreadGroup {
  static constexpr int kWarps = threads / cuda::kWarp;
  struct Warp {
    std::barrier<> barrier{cuda::kWarp};
    alignas(16) std::byte values[cuda::kWarp][128];
  };
  std::barrier<> barrier{threads};
  std::array<Warp, kWarps> warps;
};

/// A block whose threads are operating system threads that synchronise only where a device's would: a missing
/// sync() is a data race that the thread sanitizer detects.
template <int threads, class Shared>
class ThreadBlock {
public:
  template <class T>
  class PerThread {
  public:
    T& operator[](int) { return value_; }
    const T& operator[](int) const { return value_; }

  private:
    T value_;
  };

  ThreadBlock(std::int64_t index, int thread, Shared& shared, ThreadGroup<threads>& group)
      : index_(index), thread_(thread), shared_(shared), group_(group),
        warp_(group.warps[thread / cuda::kWarp]) {}

  std::int64_t index() const { return index_; }
  Shared& shared() { return shared_; }
  void sync() { group_.barrier.arrive_and_wait(); }

  template <class Phase>
  void forEachThread(Phase&& phase) {
    phase(thread_);
  }

  template <class T, int n>
  void warpSum(PerThread<cuda::Lanes<T, n>>& x) {
    std::array<cuda::Lanes<T, n>, cuda::kWarp> lanes;
    exchange(x[0], lanes);
    for (int step = cuda::kWarp / 2; step > 0; step /= 2) {
      const auto before = lanes;
      for (int lane = 0; lane < cuda::kWarp; ++lane)
        for (int c = 0; c < n; ++c)
          lanes[lane].v[c] = before[lane].v[c] + before[lane ^ step].v[c];
    }
    x[0] = lanes[thread_ % cuda::kWarp];
  }

  template <int n>
  void warpShare(PerThread<cuda::Lanes<float, n>>& x, PerThread<float>& own) {
    std::array<cuda::Lanes<float, n>, cuda::kWarp> lanes;
    exchange(x[0], lanes);
    own[0] = cuda::sharedSums(lanes)[thread_ % cuda::kWarp];
  }

  template <int n>
  void warpShare(PerThread<cuda::Lanes<float, n>>& x, PerThread<float>& own, const PerThread<bool>& active) {
    own[0] = 0;
    if (active[0]) warpShare(x, own);
  }

  void ballot(const PerThread<bool>& x, PerThread<std::uint32_t>& mask) {
    std::array<bool, cuda::kWarp> lanes;
    exchange(x[0], lanes);
    mask[0] = 0;
    for (int lane = 0; lane < cuda::kWarp; ++lane)
      if (lanes[lane]) mask[0] |= 1u << lane;
  }

private:
  /// Passes every lane's value to every lane of the warp.
  template <class T>
  void exchange(const T& own, std::array<T, cuda::kWarp>& all) {
    static_assert(sizeof(T) <= 128);
    std::memcpy(warp_.values[thread_ % cuda::kWarp], &own, sizeof(T));
    warp_.barrier.arrive_and_wait();
    for (int lane = 0; lane < cuda::kWarp; ++lane)
      std::memcpy(&all[lane], warp_.values[lane], sizeof(T));
    warp_.barrier.arrive_and_wait();
  }

  std::int64_t index_;
  int thread_;
  Shared& shared_;
  ThreadGroup<threads>& group_;
  typename ThreadGroup<threads>::Warp& warp_;
};

struct RealThreads {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    using Shared = typename Kernel::Shared;
    const auto shared = std::make_unique<Shared>();
    const auto group = std::make_unique<ThreadGroup<Kernel::kThreads>>();
    std::vector<std::thread> threads;
    for (int t = 0; t < Kernel::kThreads; ++t)
      threads.emplace_back([&, t] {
        for (std::int64_t i = 0; i < blocks; ++i) {
          ThreadBlock<Kernel::kThreads, Shared> block(i, t, *shared, *group);
          kernel(block);
          block.sync(); // the next block has the same shared memory
        }
      });
    for (std::thread& thread : threads)
      thread.join();
  }
};

} // namespace innergs::testing
