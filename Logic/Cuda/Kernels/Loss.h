#pragma once
#include "Core/Fit/PointLoss.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Bin.h"

namespace innergs::cuda {

struct SubPlaneView {
  std::int32_t plane;
  float weight;
};

/// The slices of a slab and how they are seen.
struct SliceView {
  std::int64_t slices, planeSize; // points of a padded plane
  int nx, ny, stride, perSlice;
  const SubPlaneView* subPlanes; // [slice][perSlice], planes of the slab
  const float* target;           // [slice][ny][stride]
  const std::uint8_t* weight;
  Blending blending;
  float epsilon;

  INNERGS_HD float value(Pair at) const {
    return blending == Blending::Normalised ? at.b / (at.a + epsilon) : at.b;
  }

  /// Point p of a slice as observed.
  INNERGS_HD float compose(std::int64_t slice, std::int64_t p, const Pair* planes) const {
    float sum = 0;
    for (int q = 0; q < perSlice; ++q) {
      const SubPlaneView sub = subPlanes[slice * perSlice + q];
      sum += sub.weight * value(planes[sub.plane * planeSize + p]);
    }
    return sum;
  }

  /// Turns W and N into F0 and F1 (alpha: ∂L/∂I and I) for r = ∂L/∂I of the slice.
  INNERGS_HD void spread(std::int64_t slice, std::int64_t p, float r, Pair* planes) const {
    for (int q = 0; q < perSlice; ++q) {
      const SubPlaneView sub = subPlanes[slice * perSlice + q];
      Pair& at = planes[sub.plane * planeSize + p];
      const bool normalised = blending == Blending::Normalised;
      const float inverse = normalised ? 1 / (at.a + epsilon) : 1.f;
      const float value = at.b * inverse, f0 = sub.weight * r * inverse;
      at = {f0, normalised ? -f0 * value : blending == Blending::Alpha ? value : 0.f};
    }
  }
};

/// Loss, squared error and number of samples of one block.
struct PartialLoss {
  double loss, squared;
  std::int64_t samples;
};

/// Adds up a block's sums in a fixed order; `warps`: shared memory with one entry per warp.
template <int threads, class Block, class Sums>
INNERGS_KERNEL void writePartial(Block& block, Sums& sums, Lanes<double, 3>* warps, PartialLoss* out) {
  block.warpSum(sums);
  block.sync();
  block.forEachThread([&](int t) {
    if (t % kWarp == 0) warps[t / kWarp] = sums[t];
  });
  block.sync();
  block.forEachThread([&](int t) {
    if (t != 0) return;
    Lanes<double, 3> total = {};
    for (int w = 0; w < threads / kWarp; ++w)
      for (int c = 0; c < 3; ++c)
        total.v[c] += warps[w].v[c];
    *out = {total.v[0], total.v[1], static_cast<std::int64_t>(total.v[2])};
  });
}

/// Point losses of a slab, several samples per thread. Without SSIM the gradient goes straight to the planes;
/// with it, image and r wait for SsimGradient.
struct PointLosses {
  static constexpr int kThreads = 256, kSamples = 8 * kThreads; // per block
  struct Shared {
    Lanes<double, 3> warps[kThreads / kWarp];
  };
  SliceView view;
  LossKind kind;
  float delta, pointWeight;
  Pair* planes;
  float *image, *r; // null without SSIM
  PartialLoss* partial;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<Lanes<double, 3>> sums;
    block.forEachThread([&](int t) {
      const std::int64_t first = block.index() * kSamples,
                         last = math::least(first + kSamples, view.slices * view.planeSize);
      Lanes<double, 3> sum = {};
      for (std::int64_t i = first + t; i < last; i += kThreads) {
        const std::int64_t slice = quotient(i, view.planeSize), p = i - slice * view.planeSize;
        const float seen = view.compose(slice, p, planes);
        const bool observed = view.weight[i];
        const float e = observed ? seen - view.target[i] : 0.f;
        float derivative;
        const float loss = pointLoss(kind, delta, e, derivative);
        derivative *= pointWeight;
        sum.v[0] += static_cast<double>(pointWeight) * loss;
        sum.v[1] += static_cast<double>(e) * e;
        sum.v[2] += observed ? 1 : 0;
        if (image) {
          image[i] = seen;
          r[i] = derivative;
        } else {
          view.spread(slice, p, derivative, planes);
        }
      }
      sums[t] = sum;
    });
    writePartial<kThreads>(block, sums, block.shared().warps, partial + block.index());
  }
};

/// Adds the partial sums to the iteration's; one block.
struct SumLosses {
  static constexpr int kThreads = 256;
  struct Shared {
    Lanes<double, 3> warps[kThreads / kWarp];
    PartialLoss total;
  };
  const PartialLoss* partial;
  std::int64_t count;
  IterationSums* sums;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<Lanes<double, 3>> own;
    block.forEachThread([&](int t) {
      Lanes<double, 3> sum = {};
      for (std::int64_t i = t; i < count; i += kThreads) {
        sum.v[0] += partial[i].loss;
        sum.v[1] += partial[i].squared;
        sum.v[2] += static_cast<double>(partial[i].samples);
      }
      own[t] = sum;
    });
    writePartial<kThreads>(block, own, block.shared().warps, &block.shared().total);
    block.forEachThread([&](int t) {
      if (t != 0) return;
      sums->loss += block.shared().total.loss;
      sums->squared += block.shared().total.squared;
      sums->samples += block.shared().total.samples;
    });
  }
};

} // namespace innergs::cuda
