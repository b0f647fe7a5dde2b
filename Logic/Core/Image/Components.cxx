#include "Core/Image/Components.h"

#include "Core/Base/StopToken.h"

namespace innergs {

std::vector<std::int64_t> floodFill(std::vector<std::uint8_t>& voxels, const std::array<std::int64_t, 3>& n,
                                    std::int64_t seed, const std::stop_token& stop) {
  constexpr std::size_t stride = 1 << 18; // voxels between checks of the stop token
  constexpr std::uint8_t inside = 1, visited = 2;
  std::vector<std::int64_t> reached{seed};
  voxels[seed] = visited;
  for (std::size_t head = 0; head < reached.size(); ++head) {
    if (head % stride == 0) throwIfStopped(stop);
    const std::int64_t p = reached[head], i = p % n[0], j = p / n[0] % n[1], k = p / (n[0] * n[1]);
    const auto visit = [&](bool within, std::int64_t q) {
      if (within && voxels[q] == inside) {
        voxels[q] = visited;
        reached.push_back(q);
      }
    };
    visit(i > 0, p - 1);
    visit(i + 1 < n[0], p + 1);
    visit(j > 0, p - n[0]);
    visit(j + 1 < n[1], p + n[0]);
    visit(k > 0, p - n[0] * n[1]);
    visit(k + 1 < n[2], p + n[0] * n[1]);
  }
  return reached;
}

void keepParts(std::vector<std::uint8_t>& mask, const std::array<std::int64_t, 3>& size,
               std::int64_t leastVoxels, bool largestOnly, const std::stop_token& stop) {
  std::vector<std::uint8_t> left = mask;
  std::vector<std::int64_t> largest;
  for (std::size_t seed = 0; seed < left.size(); ++seed) {
    if (left[seed] != 1) continue;
    std::vector<std::int64_t> part = floodFill(left, size, static_cast<std::int64_t>(seed), stop);
    if (largestOnly && part.size() > largest.size()) part.swap(largest);
    if (largestOnly || static_cast<std::int64_t>(part.size()) < leastVoxels)
      for (const std::int64_t voxel : part)
        mask[static_cast<std::size_t>(voxel)] = 0;
  }
  if (static_cast<std::int64_t>(largest.size()) < leastVoxels)
    for (const std::int64_t voxel : largest)
      mask[static_cast<std::size_t>(voxel)] = 0;
}

} // namespace innergs
