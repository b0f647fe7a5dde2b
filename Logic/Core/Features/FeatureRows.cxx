#include "Core/Features/FeatureRows.h"

#include "Core/Features/FeatureRenderer.h"

#include <atomic>
#include <numeric>

namespace innergs {
namespace {
constexpr std::int64_t kMostRows = 4'000'000; // bounds memory: about 10 entries of 16 bytes per row
constexpr std::uint32_t kNoRow = ~std::uint32_t{0};
} // namespace

FeatureRows rowsOf(const FeatureRenderer& renderer, const std::vector<std::uint8_t>& chosen,
                   std::int64_t voxelCount, const GaussianField& field, ThreadPool& pool) {
  const auto gaussians = static_cast<std::int64_t>(chosen.size());
  std::vector<std::atomic<std::uint8_t>> reached(static_cast<std::size_t>(voxelCount));
  pool.blocks(gaussians, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t g = first; g < last; ++g)
      if (chosen[g])
        renderer.forEachVoxel(
            g, [&](std::int64_t voxel, float) { reached[voxel].store(1, std::memory_order_relaxed); });
  });
  std::int64_t count = 0;
  for (const auto& r : reached)
    count += r.load(std::memory_order_relaxed);
  const std::int64_t every = (count + kMostRows - 1) / kMostRows;

  FeatureRows rows;
  std::vector<std::uint32_t> rowOf(static_cast<std::size_t>(voxelCount), kNoRow);
  std::uint64_t pick = 0;
  for (std::int64_t v = 0; v < voxelCount; ++v) {
    if (!reached[v].load(std::memory_order_relaxed)) continue;
    // By a hash: an even step would pick the same columns of the grid again and again.
    pick += 0x9e3779b97f4a7c15ull;
    if (every > 1 &&
        ((pick ^ (pick >> 29)) * 0xbf58476d1ce4e5b9ull >> 33) % static_cast<std::uint64_t>(every) != 0)
      continue;
    rowOf[v] = static_cast<std::uint32_t>(rows.voxels.size());
    rows.voxels.push_back(v);
  }

  rows.columnStart.assign(static_cast<std::size_t>(gaussians) + 1, 0);
  pool.blocks(gaussians, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t g = first; g < last; ++g)
      renderer.forEachVoxel(
          g, [&](std::int64_t voxel, float) { rows.columnStart[g + 1] += rowOf[voxel] != kNoRow; });
  });
  std::partial_sum(rows.columnStart.begin(), rows.columnStart.end(), rows.columnStart.begin());
  rows.columnEntries.resize(static_cast<std::size_t>(rows.columnStart.back()));
  pool.blocks(gaussians, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t g = first; g < last; ++g) {
      std::int64_t at = rows.columnStart[g];
      renderer.forEachVoxel(g, [&](std::int64_t voxel, float p) {
        if (rowOf[voxel] != kNoRow) rows.columnEntries[at++] = {rowOf[voxel], p};
      });
    }
  });

  const std::size_t size = rows.voxels.size();
  rows.rowStart.assign(size + 1, 0);
  for (const auto& entry : rows.columnEntries)
    ++rows.rowStart[entry.index + 1];
  std::partial_sum(rows.rowStart.begin(), rows.rowStart.end(), rows.rowStart.begin());
  rows.rowEntries.resize(rows.columnEntries.size());
  std::vector<std::int64_t> cursor(rows.rowStart.begin(), rows.rowStart.end() - 1);
  for (std::int64_t g = 0; g < gaussians; ++g)
    rows.forColumn(g, [&](std::uint32_t row, float p) {
      rows.rowEntries[cursor[row]++] = {static_cast<std::uint32_t>(g), p};
    });
  pool.throwIfStopped();

  std::vector<float> scale(size);
  const auto epsilon = static_cast<float>(field.epsilon);
  pool.blocks(static_cast<std::int64_t>(size), 16384, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t row = first; row < last; ++row) {
      float sum = epsilon;
      rows.forRow(row, [&](std::uint32_t, float p) { sum += p; });
      scale[row] = 1 / sum;
      for (std::int64_t n = rows.rowStart[row]; n < rows.rowStart[row + 1]; ++n)
        rows.rowEntries[n].weight *= scale[row];
    }
  });
  pool.blocks(static_cast<std::int64_t>(rows.columnEntries.size()), 65536,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t n = first; n < last; ++n)
                  rows.columnEntries[n].weight *= scale[rows.columnEntries[n].index];
              });
  return rows;
}

} // namespace innergs
