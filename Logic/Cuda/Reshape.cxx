#include "Cuda/Reshape.h"

#include <algorithm>

namespace innergs::cuda {
namespace {

constexpr int kScoreBits = 32; // of orderedBits()

/// mortonOrder() into ranking.ids(); boxes: one entry per block of BoxMeans, plus one.
void sortAlongCurve(Executor& executor, const Gaussian* gaussians, std::int64_t count, Buffer<MeanBox>& boxes,
                    Ranking& ranking) {
  const std::int64_t blocks = blocksFor(count, BoxMeans::kEach);
  executor.run(BoxMeans{gaussians, count, boxes.data()}, blocks);
  executor.run(BoxBoxes{boxes.data(), blocks, boxes.data() + blocks}, 1);
  executor.runOver(MortonKeys{gaussians, count, boxes.data() + blocks, ranking.keys(), ranking.ids()}, count);
  ranking.sort(count, kMortonBits);
}

void reserveBoxes(Buffer<MeanBox>& boxes, std::int64_t count) {
  boxes.reserve(blocksFor(count, BoxMeans::kEach) + 1);
}

void take(Executor& executor, const float* in, const std::uint32_t* ids, std::int64_t count,
          std::int64_t limit, float* out, const Guard& guard = {}) {
  executor.runOver(TakeRecords{in, ids, count, limit, out, guard}, TakeRecords::kFloats * count);
}

} // namespace

void FitBuffers::reserve(Executor& executor, std::int64_t size) {
  if (16 * size <= std::min({gaussians.size(), moment1.size(), moment2.size()}) &&
      size <= gradientSums.size())
    return;
  FitBuffers larger(executor);
  larger.gaussians.reserve(16 * size);
  larger.moment1.reserve(16 * size);
  larger.moment2.reserve(16 * size);
  larger.gradientSums.reserve(size);
  *this = std::move(larger);
}

void Ranking::reserve(std::int64_t count) {
  keys_.reserve(count);
  otherKeys_.reserve(count);
  ids_.reserve(count);
  otherIds_.reserve(count);
  executor_.prepareSort(count + 1, kScoreBits); // scans end with the total
}

void Ranking::clear() {
  keys_.clear();
  otherKeys_.clear();
  ids_.clear();
  otherIds_.clear();
}

void Relocation::reserve(std::int64_t count) {
  priority_.reserve(count);
  influence_.reserve(count);
  marks_.reserve(count);
  counts_.reserve(count + 1);
  place_.reserve(count + 1);
  replaced_.reserve(count);
  reserveBoxes(boxes_, count);
}

void Relocation::clear() {
  priority_.clear();
  influence_.clear();
  marks_.clear();
  counts_.clear();
  place_.clear();
  replaced_.clear();
}

void Relocation::run(FitBuffers& fit, Buffer<float>& spare, const RelocationPlan& plan, const Guard& guard) {
  const std::int64_t n = fit.count, moved = static_cast<std::int64_t>(plan.share * static_cast<double>(n)),
                     pairs = std::min(moved, n - moved);
  if (pairs < 1) return;
  executor_.runOver(RelocationKeys{fit.field(), fit.moment2.data(), n, priority_.keys(), influence_.keys(),
                                   priority_.ids(), influence_.ids()},
                    n);
  priority_.sort(n, kScoreBits);
  influence_.sort(n, kScoreBits);
  marks_.fill(0, n);
  executor_.runOver(MarkParents{priority_.ids(), moved, marks_.data()}, moved);
  executor_.runOver(CountReplaced{influence_.ids(), marks_.data(), n, counts_.data()}, n + 1);
  executor_.scan(counts_.data(), place_.data(), n + 1);
  executor_.runOver(TakeReplaced{influence_.ids(), marks_.data(), place_.data(), n, pairs, replaced_.data()},
                    n);
  executor_.runOver(Relocate{priority_.ids(), replaced_.data(), pairs, static_cast<float>(plan.minLogScale),
                             fit.field(), fit.moment1.data(), fit.moment2.data(), guard},
                    pairs);
  sortAlongCurve(executor_, fit.field(), n, boxes_, priority_);
  for (Buffer<float>* records : {&fit.gaussians, &fit.moment1, &fit.moment2}) {
    take(executor_, records->data(), priority_.ids(), n, n, spare.data(), guard);
    std::swap(*records, spare);
  }
}

DensifyCounts densify(Executor& executor, FitBuffers& fit, Blending blending, int iterations,
                      const DensifyPlan& plan) {
  const std::int64_t n = fit.count;
  const reshape::Rules rules = densifyRules(plan, blending, iterations);
  DensifyCounts counts;
  Ranking growing(executor), curve(executor);
  Buffer<std::int64_t> marks(executor), place(executor);
  growing.reserve(n);
  marks.reserve(n + 1);
  place.reserve(n + 1);
  executor.runOver(DensifyMarks{fit.field(), fit.gradientSums.data(), n, rules, marks.data(), growing.keys(),
                                growing.ids()},
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
  Buffer<std::int64_t> splits(executor), splitsBefore(executor);
  Buffer<std::uint32_t> order(executor), source(executor);
  Buffer<MeanBox> boxes(executor);
  next.reserve(executor, size);
  curve.reserve(size);
  unsorted.reserve(16 * size);
  splits.reserve(chosen + 1);
  splitsBefore.reserve(chosen + 1);
  order.reserve(size);
  source.reserve(size);
  reserveBoxes(boxes, size);

  growing.sort(n, kScoreBits);
  Gaussian* merged = reinterpret_cast<Gaussian*>(unsorted.data());
  executor.runOver(Densify{growing.ids(), chosen, n, rules, fit.field(), merged + kept, fit.moment1.data(),
                           fit.moment2.data(), order.data() + kept, splits.data()},
                   chosen + 1);
  executor.scan(splits.data(), splitsBefore.data(), chosen + 1);
  executor.runOver(TakeKept{marks.data(), place.data(), n, order.data()}, n);
  take(executor, fit.gaussians.data(), order.data(), kept, n, unsorted.data());
  sortAlongCurve(executor, merged, size, boxes, curve);
  executor.runOver(TakeIds{order.data(), curve.ids(), size, source.data()}, size);
  take(executor, unsorted.data(), curve.ids(), size, size, next.gaussians.data());
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
