#include "Core/Features/SupportBlocks.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr int kEdge = 6;             // of a block, in voxels
constexpr std::int64_t kAround = 4;  // voxels around a class in which it is decoded
constexpr float kLeastShare = 0.02f; // of a class in a voxel to be decoded there

} // namespace

ClassSupport supportOf(const GridGeometry& grid, const std::vector<SoftLabel>& labels, int classes,
                       ThreadPool& pool) {
  ClassSupport support;
  const auto& n = grid.size;
  support.blocks = grid;
  support.blocks.origin = grid.indexToWorld()(Vec3{(kEdge - 1) / 2.0, (kEdge - 1) / 2.0, (kEdge - 1) / 2.0});
  for (int a = 0; a < 3; ++a) {
    support.blocks.size[a] = (n[a] + kEdge - 1) / kEdge;
    support.blocks.spacing[a] *= kEdge;
  }
  support.words = (classes + 31) / 32;
  support.bits.assign(static_cast<std::size_t>(support.blocks.voxelCount() * support.words), 0);
  const auto& m = support.blocks.size;
  // Blocks [low, high] along an axis that lie around an index.
  const auto first = [](std::int64_t index) { return std::max<std::int64_t>(0, index - kAround) / kEdge; };
  const auto last = [](std::int64_t index, std::int64_t blocks) {
    return std::min(blocks - 1, (index + kAround) / kEdge);
  };
  pool.run(m[2], [&](std::int64_t z) { // a layer of blocks is one task's own
    const std::int64_t end = std::min(n[2], (z + 1) * kEdge + kAround);
    for (std::int64_t k = std::max<std::int64_t>(0, z * kEdge - kAround); k < end; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i) {
          const SoftLabel& own = labels[static_cast<std::size_t>(i + n[0] * (j + n[1] * k))];
          for (int s = 0; s < SoftLabel::kClasses && own.shares[s] > kLeastShare; ++s) {
            const int c = own.classes[s];
            for (std::int64_t y = first(j); y <= last(j, m[1]); ++y)
              for (std::int64_t x = first(i); x <= last(i, m[0]); ++x)
                support
                    .bits[static_cast<std::size_t>((x + m[0] * (y + m[1] * z)) * support.words + c / 32)] |=
                    1u << (c % 32);
          }
        }
  });
  return support;
}

} // namespace innergs
