#pragma once
#include "Cuda/Block.h"
#include "Cuda/Kernels/Reach.h"

namespace innergs::cuda {

/// The sums of one iteration.
struct IterationSums {
  double loss, squared;
  std::int64_t samples;
};

/// The results of several iterations on the device, read once at their end.
struct IterationStatus {
  static constexpr int kMost = 64;
  std::int64_t pairs; // the most (Gaussian, bin) pairs in any slab
  std::int64_t done;  // iterations that changed the parameters
  IterationSums sums[kMost];
};

/// Blocks further changes once there were more pairs than room for them.
struct Guard {
  const IterationStatus* status = nullptr;
  std::int64_t limit = 0;

  INNERGS_HD bool closed() const { return status && status->pairs > limit; }
};

template <class Reach>
INNERGS_HD inline std::int64_t pairsOf(const Reach& reach, const Projected& g) {
  std::int64_t n = 0;
  if constexpr (requires { Reach::kEdge; })
    reach.visit(g, [&](std::uint64_t, float) { ++n; });
  else
    reach.visit(g, [&](std::uint64_t) { ++n; });
  return n;
}

/// The number of bins that each Gaussian reaches, plus a final 0, so that a scan ends with the total.
template <class Reach>
struct CountPairs {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Projected* gaussians;
  std::int64_t count;
  Reach reach;
  std::int64_t* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count + 1,
                          [&](std::int64_t i) { out[i] = i < count ? pairsOf(reach, gaussians[i]) : 0; });
  }
};

/// Writes the pairs' keys and Gaussians in the order of the Gaussians, or none if there are more than
/// `limit`. Alpha blending sorts the pairs' positions instead, and `owners` holds their Gaussians.
template <class Reach>
struct EmitPairs {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Projected* gaussians;
  std::int64_t count;
  Reach reach;
  const std::int64_t* first; // count + 1
  std::int64_t limit;
  std::uint64_t* keys;
  std::uint32_t* ids;
  std::uint32_t* owners; // TileReach only
  IterationStatus* status;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count + 1, [&](std::int64_t i) {
      const std::int64_t total = first[count];
      if (i == 0) status->pairs = math::most(status->pairs, total);
      if (i >= count || total > limit) return;
      std::int64_t at = first[i];
      const auto put = [&](std::uint64_t key) {
        keys[at] = key;
        if (owners) owners[at] = static_cast<std::uint32_t>(i);
        ids[at] = static_cast<std::uint32_t>(owners ? at : i);
        ++at;
      };
      if constexpr (requires { Reach::kEdge; })
        reach.visit(gaussians[i], [&](std::uint64_t key, float) { put(key); });
      else
        reach.visit(gaussians[i], put);
    });
  }
};

/// Where each bin begins in the sorted pairs: start[bins + 1]. Keys ≥ `bins` (after the shift) are unused.
struct FindStarts {
  static constexpr int kThreads = 256;
  using Shared = Nothing;
  const std::uint64_t* keys; // sorted
  std::int64_t pairs, bins;
  int shift;
  std::int64_t* start;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, bins + 1, [&](std::int64_t bin) {
      std::int64_t low = 0, high = pairs;
      while (low < high) {
        const std::int64_t middle = (low + high) / 2;
        if (keys[middle] >> shift < static_cast<std::uint64_t>(bin))
          low = middle + 1;
        else
          high = middle;
      }
      start[bin] = low;
    });
  }
};

} // namespace innergs::cuda
