#include "Cuda/Reshape.h"

#include <algorithm>

namespace innergs::cuda {
namespace {

constexpr int kScoreBits = 32; // of orderedBits()

/// Numbers of Gaussians with their keys, to be sorted.
struct Ranking {
  Ranking(Executor& executor, std::int64_t count)
      : keys(executor), otherKeys(executor), ids(executor), otherIds(executor) {
    keys.reserve(count);
    otherKeys.reserve(count);
    ids.reserve(count);
    otherIds.reserve(count);
  }
  void sort(Executor& executor, std::int64_t count, int bits) {
    sortPairs(executor, keys, otherKeys, ids, otherIds, count, bits);
  }

  Buffer<std::uint64_t> keys, otherKeys;
  Buffer<std::uint32_t> ids, otherIds;
};

/// mortonOrder() into ranking.ids; boxes: one entry a block of BoxMeans and one more.
void sortAlongCurve(Executor& executor, const Gaussian* gaussians, std::int64_t count, Buffer<MeanBox>& boxes,
                    Ranking& ranking) {
  const std::int64_t blocks = blocksFor(count, BoxMeans::kEach);
  executor.run(BoxMeans{gaussians, count, boxes.data()}, blocks);
  executor.run(BoxBoxes{boxes.data(), blocks, boxes.data() + blocks}, 1);
  executor.runOver(
      MortonKeys{gaussians, count, boxes.data() + blocks, ranking.keys.data(), ranking.ids.data()}, count);
  ranking.sort(executor, count, kMortonBits);
}

void reserveBoxes(Buffer<MeanBox>& boxes, std::int64_t count) {
  boxes.reserve(blocksFor(count, BoxMeans::kEach) + 1);
}

void take(Executor& executor, const float* in, const std::uint32_t* ids, std::int64_t count,
          std::int64_t limit, float* out) {
  executor.runOver(TakeRecords{in, ids, count, limit, out}, TakeRecords::kFloats * count);
}

} // namespace

void FitBuffers::reserve(Executor& executor, std::int64_t size) {
  if (16 * size <= std::min({gaussians.size(), moment1.size(), moment2.size()}) && size <= pulls.size())
    return;
  FitBuffers larger(executor);
  larger.gaussians.reserve(16 * size);
  larger.moment1.reserve(16 * size);
  larger.moment2.reserve(16 * size);
  larger.pulls.reserve(size);
  *this = std::move(larger);
}

void relocate(Executor& executor, FitBuffers& fit, Buffer<float>& spare, const RelocationPlan& plan) {
  const std::int64_t n = fit.count, moved = static_cast<std::int64_t>(plan.share * static_cast<double>(n)),
                     pairs = std::min(moved, n - moved);
  if (pairs < 1) return;
  // All memory first: what comes then cannot fail half way.
  Ranking need(executor, n), use(executor, n);
  Buffer<std::uint8_t> marks(executor);
  Buffer<std::int64_t> counts(executor), place(executor);
  Buffer<std::uint32_t> victims(executor);
  Buffer<MeanBox> boxes(executor);
  marks.reserve(n);
  counts.reserve(n + 1);
  place.reserve(n + 1);
  victims.reserve(pairs);
  reserveBoxes(boxes, n);
  spare.reserve(16 * n);

  executor.runOver(RelocationKeys{fit.field(), fit.moment2.data(), n, need.keys.data(), use.keys.data(),
                                  need.ids.data(), use.ids.data()},
                   n);
  need.sort(executor, n, kScoreBits);
  use.sort(executor, n, kScoreBits);
  marks.fill(0, n);
  executor.runOver(MarkParents{need.ids.data(), moved, marks.data()}, moved);
  executor.runOver(CountVictims{use.ids.data(), marks.data(), n, counts.data()}, n + 1);
  executor.scan(counts.data(), place.data(), n + 1);
  executor.runOver(TakeVictims{use.ids.data(), marks.data(), place.data(), n, pairs, victims.data()}, n);
  executor.runOver(Relocate{need.ids.data(), victims.data(), pairs, static_cast<float>(plan.minLogScale),
                            fit.field(), fit.moment1.data(), fit.moment2.data()},
                   pairs);
  sortAlongCurve(executor, fit.field(), n, boxes, need);
  for (Buffer<float>* records : {&fit.gaussians, &fit.moment1, &fit.moment2}) {
    take(executor, records->data(), need.ids.data(), n, n, spare.data());
    std::swap(*records, spare);
  }
}

DensifyCounts densify(Executor& executor, FitBuffers& fit, Blending blending, int sweeps,
                      const DensifyPlan& plan) {
  const std::int64_t n = fit.count;
  const reshape::Rules rules = densifyRules(plan, blending, sweeps);
  DensifyCounts counts;
  Ranking pulled(executor, n);
  Buffer<std::int64_t> marks(executor), place(executor);
  marks.reserve(n + 1);
  place.reserve(n + 1);
  executor.runOver(DensifyMarks{fit.field(), fit.pulls.data(), n, rules, marks.data(), pulled.keys.data(),
                                pulled.ids.data()},
                   n + 1);
  executor.scan(marks.data(), place.data(), n + 1);
  std::int64_t totals = 0;
  executor.download(&totals, place.data() + n, sizeof totals);
  const std::int64_t kept = totals & 0xffffffff,
                     chosen = std::min(totals >> DensifyMarks::kUpper,
                                       std::max<std::int64_t>(0, plan.limit - kept));
  const std::int64_t size = kept + chosen;
  if (kept == 0 || (kept == n && chosen == 0)) return counts;

  FitBuffers next(executor);
  Buffer<float> unsorted(executor);
  Ranking curve(executor, size);
  Buffer<std::int64_t> splits(executor), splitsBefore(executor);
  Buffer<std::uint32_t> order(executor), source(executor);
  Buffer<MeanBox> boxes(executor);
  next.reserve(executor, size);
  unsorted.reserve(16 * size);
  splits.reserve(chosen + 1);
  splitsBefore.reserve(chosen + 1);
  order.reserve(size);
  source.reserve(size);
  reserveBoxes(boxes, size);

  pulled.sort(executor, n, kScoreBits);
  Gaussian* merged = reinterpret_cast<Gaussian*>(unsorted.data());
  executor.runOver(Densify{pulled.ids.data(), chosen, n, rules, fit.field(), merged + kept,
                           fit.moment1.data(), fit.moment2.data(), order.data() + kept, splits.data()},
                   chosen + 1);
  executor.scan(splits.data(), splitsBefore.data(), chosen + 1);
  executor.runOver(TakeKept{marks.data(), place.data(), n, order.data()}, n);
  take(executor, fit.gaussians.data(), order.data(), kept, n, unsorted.data());
  sortAlongCurve(executor, merged, size, boxes, curve);
  executor.runOver(TakeIds{order.data(), curve.ids.data(), size, source.data()}, size);
  take(executor, unsorted.data(), curve.ids.data(), size, size, next.gaussians.data());
  take(executor, fit.moment1.data(), source.data(), size, n, next.moment1.data());
  take(executor, fit.moment2.data(), source.data(), size, n, next.moment2.data());
  next.count = size;
  executor.download(&counts.split, splitsBefore.data() + chosen, sizeof counts.split);
  fit = std::move(next);
  counts.pruned = n - kept;
  counts.cloned = chosen - counts.split;
  return counts;
}

} // namespace innergs::cuda
