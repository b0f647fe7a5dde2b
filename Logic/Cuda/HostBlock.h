#pragma once
#include "Cuda/Block.h"

#include <array>

namespace innergs::cuda {

/// What warpShare() gives each lane, added in the device's order.
template <int n>
std::array<float, kWarp> sharedSums(std::array<Lanes<float, n>, kWarp> lanes) {
  for (int width = n / 2; width > 0; width /= 2) {
    const int step = kWarp * width / n;
    const auto before = lanes;
    for (int lane = 0; lane < kWarp; ++lane)
      for (int c = 0; c < width; ++c) {
        const int kept = lane & step ? c + width : c;
        lanes[lane].v[c] = before[lane].v[kept] + before[lane ^ step].v[kept];
      }
  }
  for (int step = kWarp / n / 2; step > 0; step /= 2) {
    const auto before = lanes;
    for (int lane = 0; lane < kWarp; ++lane)
      lanes[lane].v[0] = before[lane].v[0] + before[lane ^ step].v[0];
  }
  std::array<float, kWarp> sums;
  for (int lane = 0; lane < kWarp; ++lane)
    sums[lane] = lanes[lane].v[0];
  return sums;
}

/// A block of threads on the host: within a phase, the threads run one after another.
template <int threads, class Shared>
class HostBlock {
public:
  template <class T>
  class PerThread {
  public:
    T& operator[](int thread) { return values_[thread]; }
    const T& operator[](int thread) const { return values_[thread]; }

  private:
    std::array<T, threads> values_;
  };

  HostBlock(std::int64_t index, Shared& shared) : index_(index), shared_(shared) {}

  std::int64_t index() const { return index_; }
  Shared& shared() { return shared_; }
  void sync() {}

  template <class Phase>
  void forEachThread(Phase&& phase) {
    for (int t = 0; t < threads; ++t)
      phase(t);
  }

  template <class T, int n>
  void warpSum(PerThread<Lanes<T, n>>& x) {
    for (int warp = 0; warp < threads; warp += kWarp)
      sumOne(x, warp);
  }

  template <int n>
  void warpShare(PerThread<Lanes<float, n>>& x, PerThread<float>& own) {
    for (int warp = 0; warp < threads; warp += kWarp)
      shareOne(x, own, warp);
  }

  template <int n>
  void warpShare(PerThread<Lanes<float, n>>& x, PerThread<float>& own, const PerThread<bool>& active) {
    for (int warp = 0; warp < threads; warp += kWarp)
      if (active[warp])
        shareOne(x, own, warp);
      else
        for (int lane = 0; lane < kWarp; ++lane)
          own[warp + lane] = 0;
  }

  void ballot(const PerThread<bool>& x, PerThread<std::uint32_t>& mask) {
    for (int warp = 0; warp < threads; warp += kWarp) {
      std::uint32_t bits = 0;
      for (int lane = 0; lane < kWarp; ++lane)
        if (x[warp + lane]) bits |= 1u << lane;
      for (int lane = 0; lane < kWarp; ++lane)
        mask[warp + lane] = bits;
    }
  }

private:
  /// Adds in the order of the device's butterfly shuffles.
  template <class T, int n>
  static void sumOne(PerThread<Lanes<T, n>>& x, int warp) {
    for (int step = kWarp / 2; step > 0; step /= 2) {
      std::array<Lanes<T, n>, kWarp> before;
      for (int lane = 0; lane < kWarp; ++lane)
        before[lane] = x[warp + lane];
      for (int lane = 0; lane < kWarp; ++lane)
        for (int c = 0; c < n; ++c)
          x[warp + lane].v[c] = before[lane].v[c] + before[lane ^ step].v[c];
    }
  }

  template <int n>
  static void shareOne(PerThread<Lanes<float, n>>& x, PerThread<float>& own, int warp) {
    std::array<Lanes<float, n>, kWarp> lanes;
    for (int lane = 0; lane < kWarp; ++lane)
      lanes[lane] = x[warp + lane];
    const auto sums = sharedSums(lanes);
    for (int lane = 0; lane < kWarp; ++lane)
      own[warp + lane] = sums[lane];
  }

  std::int64_t index_;
  Shared& shared_;
};

} // namespace innergs::cuda
