#pragma once
#include "Core/Fit/Reshape.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Bin.h"

#include <cstring>

namespace innergs::cuda {

/// Unsigned numbers that sort like the floats; 0 and −0 are equal.
INNERGS_HD inline std::uint32_t orderedBits(float x) {
  x += 0.f;
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// Relocation: keys that sort Gaussians by falling split priority and by rising influence.
struct RelocationKeys {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Gaussian* gaussians;
  const float* moment2;
  std::int64_t count;
  std::uint64_t *priority, *influence;
  std::uint32_t *byPriority, *byInfluence;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      priority[i] =
          static_cast<std::uint32_t>(~orderedBits(reshape::splitPriority(gaussians[i], moment2 + 16 * i)));
      influence[i] = orderedBits(reshape::influence(moment2 + 16 * i));
      byPriority[i] = byInfluence[i] = static_cast<std::uint32_t>(i);
    });
  }
};

struct MarkParents {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t* parents;
  std::int64_t count;
  std::uint8_t* marks; // of all Gaussians

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t k) { marks[parents[k]] = 1; });
  }
};

/// 1 for each of `byInfluence` that is not a parent, plus a final 0, so that a scan ends with the total.
struct CountReplaced {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t* byInfluence;
  const std::uint8_t* marks;
  std::int64_t count;
  std::int64_t* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count + 1,
                          [&](std::int64_t k) { out[k] = k < count && !marks[byInfluence[k]]; });
  }
};

/// Takes the first `most` of them.
struct TakeReplaced {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t* byInfluence;
  const std::uint8_t* marks;
  const std::int64_t* place; // scan of CountReplaced
  std::int64_t count, most;
  std::uint32_t* replaced;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t k) {
      if (!marks[byInfluence[k]] && place[k] < most) replaced[place[k]] = byInfluence[k];
    });
  }
};

/// The halves of the k-th parent go to its own place and to the k-th replaced one's.
struct Relocate {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t *parents, *replaced;
  std::int64_t count;
  float minLogScale;
  Gaussian* gaussians;
  float *moment1, *moment2;
  Guard guard;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t k) {
      if (guard.closed()) return;
      const std::int64_t both[2] = {parents[k], replaced[k]};
      const Gaussian parent = gaussians[both[0]];
      reshape::split(parent, minLogScale, gaussians[both[0]], gaussians[both[1]]);
      for (std::int64_t i : both)
        for (int c = 0; c < 16; ++c)
          moment1[16 * i + c] = moment2[16 * i + c] = 0;
    });
  }
};

/// Densification: a kept Gaussian counts 1 in the lower half of a mark, one that becomes two counts 1 in the
/// upper half; plus a final 0. Keys sort the latter by falling gradient, with all others behind them.
struct DensifyMarks {
  static constexpr int kThreads = 128, kUpper = 32;
  using Shared = Nothing;
  const Gaussian* gaussians;
  const float* gradientSums;
  std::int64_t count;
  reshape::Rules rules;
  std::int64_t* marks;
  std::uint64_t* keys;
  std::uint32_t* ids;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count + 1, [&](std::int64_t i) {
      if (i == count) {
        marks[i] = 0;
        return;
      }
      const bool stays = !reshape::pruned(gaussians[i], rules),
                 growing = stays && gradientSums[i] > rules.gradient;
      marks[i] = static_cast<std::int64_t>(stays) + (static_cast<std::int64_t>(growing) << kUpper);
      keys[i] = growing ? static_cast<std::uint32_t>(~orderedBits(gradientSums[i])) : 0xffffffffu;
      ids[i] = static_cast<std::uint32_t>(i);
    });
  }
};

/// Takes the kept Gaussians, in order.
struct TakeKept {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::int64_t *marks, *place; // DensifyMarks and its scan
  std::int64_t count;
  std::uint32_t* order;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      if (marks[i] & 1) order[static_cast<std::uint32_t>(place[i])] = static_cast<std::uint32_t>(i);
    });
  }
};

/// Adds a Gaussian for each of those with the largest gradients, as number count + k. splits: whether by a
/// split, plus a final 0. The parent of a split restarts with zero moments.
struct Densify {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t* growing;
  std::int64_t chosen, count;
  reshape::Rules rules;
  Gaussian *gaussians, *added;
  float *moment1, *moment2;
  std::uint32_t* order; // of the added ones
  std::int64_t* splits;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, chosen + 1, [&](std::int64_t k) {
      splits[k] = 0;
      if (k == chosen) return;
      const std::int64_t i = growing[k];
      order[k] = static_cast<std::uint32_t>(count + k);
      if (!reshape::densify(gaussians[i], moment1 + 16 * i, rules, added[k])) return;
      splits[k] = 1;
      for (int c = 0; c < 16; ++c)
        moment1[16 * i + c] = moment2[16 * i + c] = 0;
    });
  }
};

} // namespace innergs::cuda
