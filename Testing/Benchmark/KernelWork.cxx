#include "KernelWork.h"

#include "Core/Render/Projected.h"
#include "Cuda/Passes.h"

#include <algorithm>
#include <cmath>

namespace innergs::bench {

using cuda::Accumulate;
using cuda::BrickReach;
using cuda::Buffer;
using cuda::Gather;

struct HeavyKernels::Impl {
  cuda::Executor& executor;
  std::int64_t count;
  cuda::DevicePlanes planes;
  BrickReach bricks;
  Buffer<Projected> projected{executor};
  Buffer<std::int64_t> start{executor};
  Buffer<std::uint32_t> ids{executor};
  Buffer<cuda::Pair> out{executor};
  Buffer<math::Moments<float>> moments{executor};

  Impl(cuda::Executor& e, const GaussianField& field, const Observation& o)
      : executor(e), count(field.size()), planes(e, o.grid, 0, o.grid.planes()),
        bricks(cuda::bricksOf(planes.view())) {}
};

namespace {

/// Instructions per warp, counted in the disassembly (Docs/cuda.md).
namespace sass {
constexpr double accumulateBrick = 250, accumulateBatch = 164, accumulateGaussian = 67;
constexpr double gatherGaussian = 290, gatherPlane = 86, gatherRows = 102, gatherPoints = 26;
} // namespace sass

/// The work of a warp for one Gaussian in Gather.
void countGather(const Projected& g, const GridView& grid, KernelWork& work) {
  const int lanes = 1 << cuda::GatherRows::laneBits(g);
  const int step = cuda::kWarp / lanes;
  work.instructions += sass::gatherGaussian;
  int k0, k1;
  planeRange(g, grid, k0, k1);
  for (int k = k0; k < k1; ++k) {
    work.instructions += sass::gatherPlane;
    const float dz = planeOffset(g, grid.z[k]);
    int r0, r1;
    if (!rowRange(g, dz, r0, r1)) continue;
    const std::int64_t cell = g.cell[1];
    const auto y0 = std::clamp<std::int64_t>(cell + r0, 0, grid.ny),
               y1 = std::clamp<std::int64_t>(cell + r1, 0, grid.ny);
    for (std::int64_t from = y0; from < y1; from += step) {
      std::int64_t widest = 0;
      for (std::int64_t y = from; y < std::min(y1, from + step); ++y) {
        const float dy = static_cast<float>(y - cell) - g.fraction[1];
        float centre, half;
        ellipsoidRow(g, dy, dz, centre, half);
        const auto column = [&](int x) { return std::clamp<std::int64_t>(g.cell[0] + x, 0, grid.nx); };
        const std::int64_t width = column(indexUpTo(centre + half) + 1) - column(indexFrom(centre - half));
        widest = std::max(widest, width);
        work.evaluations += static_cast<double>(std::max<std::int64_t>(0, width));
      }
      const double steps = std::ceil(static_cast<double>(widest) / lanes);
      work.instructions += sass::gatherRows + sass::gatherPoints * steps;
    }
  }
}

} // namespace

HeavyKernels::HeavyKernels(cuda::Executor& executor, const GaussianField& field, const Observation& o)
    : impl_(std::make_unique<Impl>(executor, field, o)) {
  ThreadPool pool;
  std::vector<Projected> host;
  project(field, {}, o.grid, o.psf, pool, host);
  const SampleGrid& l = o.grid;
  const GridView view{l.nx, l.ny, l.planes(), l.stride(), l.z.data()};
  BrickReach bricks = impl_->bricks;
  bricks.grid = view; // in host memory
  std::vector<std::vector<std::uint32_t>> lists(static_cast<std::size_t>(bricks.count()));
  for (std::size_t i = 0; i < host.size(); ++i) {
    bricks.visit(host[i], [&](std::uint64_t b) { lists[b].push_back(static_cast<std::uint32_t>(i)); });
    countGather(host[i], view, gatherWork);
  }
  std::vector<std::int64_t> start{0};
  std::vector<std::uint32_t> ids;
  const auto shared = std::make_unique<Accumulate::Shared>();
  constexpr int warps = Accumulate::kThreads / cuda::kWarp;
  for (std::size_t b = 0; b < lists.size(); ++b) {
    const int n = static_cast<int>(b), bx = n % bricks.nx * BrickReach::kX,
              by = n / bricks.nx % bricks.ny * BrickReach::kY,
              bz = n / bricks.nx / bricks.ny * BrickReach::kZ;
    const auto pairs = static_cast<double>(lists[b].size());
    accumulateWork.instructions +=
        warps * (sass::accumulateBrick + sass::accumulateBatch * std::ceil(pairs / Accumulate::kBatch));
    for (const std::uint32_t id : lists[b]) {
      Accumulate::stage(host[id], view, bx, by, bz, 0, *shared);
      for (int w = 0; w < warps; ++w)
        if (Accumulate::meets(*shared, 0, 0, w % 2 * 8, 8) && Accumulate::meets(*shared, 0, 1, w / 2 * 4, 4))
          accumulateWork.instructions += sass::accumulateGaussian;
    }
    ids.insert(ids.end(), lists[b].begin(), lists[b].end());
    start.push_back(static_cast<std::int64_t>(ids.size()));
  }
  accumulateWork.evaluations = gatherWork.evaluations;
  // Exponent by 2 multiply-adds within a column, the exponential, the cut and 3 multiply-adds with their
  // sums.
  accumulateWork.flops = 14 * accumulateWork.evaluations;
  gatherWork.flops = 24 * gatherWork.evaluations; // exponent, exponential, value and six sums
  const auto points = static_cast<double>(l.bufferSize()), gaussians = static_cast<double>(host.size());
  accumulateWork.bytes = 8 * points + 4 * static_cast<double>(ids.size()) + sizeof(Projected) * gaussians;
  gatherWork.bytes = 8 * points + (sizeof(Projected) + 56.0) * gaussians;

  impl_->projected.upload(host.data(), static_cast<std::int64_t>(host.size()));
  impl_->start.upload(start.data(), static_cast<std::int64_t>(start.size()));
  impl_->ids.upload(ids.data(), static_cast<std::int64_t>(ids.size()));
  impl_->out.reserve(static_cast<std::int64_t>(l.bufferSize()));
  impl_->out.fill(0, impl_->out.size());
  impl_->moments.reserve(impl_->count);
}

HeavyKernels::~HeavyKernels() = default;

void HeavyKernels::accumulate() {
  impl_->executor.run(Accumulate{impl_->projected.data(), impl_->bricks, impl_->start.data(),
                                 impl_->ids.data(), impl_->out.data()},
                      impl_->bricks.count());
}

void HeavyKernels::gather() {
  impl_->executor.run(Gather{impl_->projected.data(),
                             impl_->count,
                             {impl_->planes.view(), impl_->out.data()},
                             impl_->moments.data(),
                             false},
                      cuda::blocksFor(impl_->count, Gather::kWarps));
}

} // namespace innergs::bench
