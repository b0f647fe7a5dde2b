#include "Cuda/Passes.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace innergs::cuda {
namespace {

int divideUp(int a, int b) {
  return (a + b - 1) / b;
}

SsimTile ssimTile(const SliceView& slices) {
  SsimTile tile{slices, slices.stride / SsimTile::kEdge, divideUp(slices.ny, SsimTile::kEdge), {}};
  const auto window = ssimWindow();
  std::copy(window.begin(), window.end(), tile.window);
  return tile;
}

} // namespace

BrickReach bricksOf(const GridView& l) {
  return {l, divideUp(l.nx, BrickReach::kX), divideUp(l.ny, BrickReach::kY), divideUp(l.nz, BrickReach::kZ)};
}

TileReach tilesOf(const GridView& l) {
  return {l, divideUp(l.nx, TileReach::kEdge), divideUp(l.ny, TileReach::kEdge)};
}

DevicePlanes::DevicePlanes(Executor& executor, const SampleGrid& grid, int firstPlane, int planes)
    : nx(grid.nx), ny(grid.ny), nz(planes), stride(grid.stride()), z(executor) {
  z.upload(grid.z.data() + firstPlane, planes);
}

Passes::Passes(Executor& e)
    : executor_(e), projected_(e), counts_(e), first_(e), start_(e), keys_(e), otherKeys_(e), ids_(e),
      otherIds_(e), owners_(e), slots_(e), moments_(e), planes_(e), image_(e), r_(e), dMean_(e), dSquare_(e),
      dProduct_(e), partial_(e), status_(e) {
  status_.reserve(1);
  clearStatus();
}

void Passes::shrink() {
  for (auto* b : {&image_, &r_, &dMean_, &dSquare_, &dProduct_})
    b->clear();
  planes_.clear();
  start_.clear();
  keys_.clear();
  otherKeys_.clear();
  ids_.clear();
  otherIds_.clear();
  owners_.clear();
  slots_.clear();
  partial_.clear();
}

IterationStatus Passes::status() const {
  IterationStatus status;
  status_.download(&status, 1);
  return status;
}

void Passes::project(const Gaussian* gaussians, const float* values, std::int64_t count,
                     const ProjectionFrame& frame, const ProjectionRules& rules) {
  count_ = count;
  projected_.reserve(count);
  executor_.runOver(Project{gaussians, values, count, frame, rules, projected_.data()}, count);
}

template <class Reach>
void Passes::bin(const Reach& reach, int shift, bool alpha) {
  counts_.reserve(count_ + 1);
  first_.reserve(count_ + 1);
  executor_.runOver(CountPairs<Reach>{projected_.data(), count_, reach, counts_.data()}, count_ + 1);
  executor_.scan(counts_.data(), first_.data(), count_ + 1);
  std::int64_t limit = 0;
  if (limit_)
    limit = *limit_;
  else
    executor_.download(&limit, first_.data() + count_, sizeof limit);
  const std::int64_t bins = reach.count();
  if (limit > std::numeric_limits<std::uint32_t>::max() || bins > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorCode::Memory,
                "A slab has too many pairs of Gaussians and tiles for the device: use fewer "
                "or smaller Gaussians, or the CPU.");
  pairs_ = limit;
  keys_.reserve(limit);
  otherKeys_.reserve(limit);
  ids_.reserve(limit);
  otherIds_.reserve(limit);
  if (alpha) owners_.reserve(limit);
  start_.reserve(bins + 1);
  keys_.fill(0xff, limit); // sorts after all bins
  ids_.fill(0, limit);
  executor_.runOver(EmitPairs<Reach>{projected_.data(), count_, reach, first_.data(), limit, keys_.data(),
                                     ids_.data(), alpha ? owners_.data() : nullptr, status_.data()},
                    count_ + 1);
  sortPairs(executor_, keys_, otherKeys_, ids_, otherIds_, limit,
            shift + std::bit_width(static_cast<std::uint64_t>(bins)));
  executor_.runOver(FindStarts{keys_.data(), limit, bins, shift, start_.data()}, bins + 1);
}

AlphaTile Passes::alphaTile(const TileReach& tiles) const {
  return {tiles, projected_.data(), start_.data(), ids_.data(), owners_.data()};
}

void Passes::forward(const DevicePlanes& grid, Blending blending, int point, int points) {
  const std::int64_t size = grid.planeSize() * grid.nz;
  if (point == 0) planes_.reserve(size * points);
  Pair* planes = planes_.data() + size * point;
  if (blending == Blending::Alpha) {
    const TileReach tiles = tilesOf(grid.view());
    bin(tiles, 32, true);
    executor_.run(Composite{alphaTile(tiles), planes}, tiles.count());
    return;
  }
  const BrickReach bricks = bricksOf(grid.view());
  bin(bricks, 0, false);
  executor_.run(Accumulate{projected_.data(), bricks, start_.data(), ids_.data(), planes}, bricks.count());
}

void Passes::loss(const SliceView& slices, const LossKinds& kinds, int iteration) {
  const std::int64_t points = slices.slices * slices.planeSize;
  const bool ssim = kinds.ssimWeight > 0;
  const SsimTile tile = ssimTile(slices);
  const std::int64_t blocks = blocksFor(points, PointLosses::kSamples),
                     tiles = ssim ? slices.slices * tile.tilesX * tile.tilesY : 0;
  partial_.reserve(blocks + tiles);
  if (ssim)
    for (auto* b : {&image_, &r_, &dMean_, &dSquare_, &dProduct_})
      b->reserve(points);
  executor_.run(PointLosses{slices, kinds.kind, static_cast<float>(kinds.huberDelta),
                            static_cast<float>(kinds.pointWeight), planes_.data(),
                            ssim ? image_.data() : nullptr, ssim ? r_.data() : nullptr, partial_.data()},
                blocks);
  if (ssim) {
    executor_.run(SsimTerms{tile, kinds.ssimWeight, image_.data(), dMean_.data(), dSquare_.data(),
                            dProduct_.data(), partial_.data() + blocks},
                  tiles);
    executor_.run(SsimGradient{tile, static_cast<float>(kinds.ssimWeight), image_.data(), r_.data(),
                               dMean_.data(), dSquare_.data(), dProduct_.data(), planes_.data()},
                  tiles);
  }
  executor_.run(SumLosses{partial_.data(), blocks + tiles, status_.data()->sums + iteration}, 1);
}

void Passes::backward(const DevicePlanes& grid, Blending blending, bool add, int point, bool again) {
  Pair* planes = planes_.data() + grid.planeSize() * grid.nz * point;
  moments_.reserve(count_);
  if (blending == Blending::Alpha) {
    const TileReach tiles = tilesOf(grid.view());
    if (again) bin(tiles, 32, true);
    slots_.reserve(pairs_);
    executor_.run(CompositeBackward{alphaTile(tiles), planes, slots_.data()}, tiles.count());
    executor_.runOver(SumSlots{projected_.data(), count_, tiles, first_.data(), pairs_, slots_.data(),
                               moments_.data(), add},
                      count_);
    return;
  }
  const GatherRows rows{grid.view(), planes};
  executor_.run(Gather{projected_.data(), count_, rows, moments_.data(), add},
                blocksFor(count_, Gather::kWarps));
  executor_.run(GatherLarge{projected_.data(), count_, rows, moments_.data(), add}, blocksFor(count_, kWarp));
}

void Passes::query(const CellReach& cells, const double* points, std::int64_t count, Blending blending,
                   float epsilon, float* out) {
  bin(cells, 0, false);
  executor_.runOver(QueryPoints{projected_.data(), cells, start_.data(), ids_.data(), points, count, blending,
                                epsilon, out},
                    count);
}

} // namespace innergs::cuda
