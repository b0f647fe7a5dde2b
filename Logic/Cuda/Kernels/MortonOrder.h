#pragma once
#include "Core/Model/Morton.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Bin.h"

namespace innergs::cuda {

/// Joins one box per thread; `boxes`: kThreads entries of shared memory.
template <int threads, class Block, class Boxes>
INNERGS_KERNEL void joinBoxes(Block& block, Boxes& own, MeanBox* boxes, MeanBox* out) {
  block.forEachThread([&](int t) { boxes[t] = own[t]; });
  block.sync();
  block.forEachThread([&](int t) {
    if (t != 0) return;
    MeanBox all = MeanBox::empty();
    for (int i = 0; i < threads; ++i)
      all.add(boxes[i].low, boxes[i].high);
    *out = all;
  });
}

/// The box of the means of kEach Gaussians per block.
struct BoxMeans {
  static constexpr int kThreads = 128, kEach = 32 * kThreads;
  struct Shared {
    MeanBox boxes[kThreads];
  };
  const Gaussian* gaussians;
  std::int64_t count;
  MeanBox* out; // one per block

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<MeanBox> own;
    block.forEachThread([&](int t) {
      const std::int64_t first = block.index() * kEach, last = math::least(count, first + kEach);
      own[t] = MeanBox::empty();
      for (std::int64_t i = first + t; i < last; i += kThreads)
        own[t].add(gaussians[i].mean, gaussians[i].mean);
    });
    joinBoxes<kThreads>(block, own, block.shared().boxes, out + block.index());
  }
};

/// Joins the boxes; one block.
struct BoxBoxes {
  static constexpr int kThreads = 128;
  struct Shared {
    MeanBox boxes[kThreads];
  };
  const MeanBox* boxes;
  std::int64_t count;
  MeanBox* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<MeanBox> own;
    block.forEachThread([&](int t) {
      own[t] = MeanBox::empty();
      for (std::int64_t i = t; i < count; i += kThreads)
        own[t].add(boxes[i].low, boxes[i].high);
    });
    joinBoxes<kThreads>(block, own, block.shared().boxes, out);
  }
};

struct MortonKeys {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Gaussian* gaussians;
  std::int64_t count;
  const MeanBox* box;
  std::uint64_t* keys;
  std::uint32_t* ids;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      keys[i] = mortonCode(gaussians[i], *box);
      ids[i] = static_cast<std::uint32_t>(i);
    });
  }
};

/// out[i] = in[ids[i]].
struct TakeIds {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const std::uint32_t *in, *ids;
  std::int64_t count;
  std::uint32_t* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) { out[i] = in[ids[i]]; });
  }
};

/// The same for records of 16 floats, one thread per float; 0 for those at or past `limit`. Behind a closed
/// guard they keep their order.
struct TakeRecords {
  static constexpr int kThreads = 256, kFloats = 16;
  using Shared = Nothing;
  const float* in;
  const std::uint32_t* ids;
  std::int64_t count, limit;
  float* out;
  Guard guard;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, kFloats * count, [&](std::int64_t i) {
      const std::int64_t from = guard.closed() ? i / kFloats : ids[i / kFloats];
      out[i] = from < limit ? in[kFloats * from + i % kFloats] : 0.f;
    });
  }
};

} // namespace innergs::cuda
