#include "Core/Image/FilledImage.h"

#include "Core/Base/StopToken.h"

#include <cmath>

namespace innergs {

FilledImage filledImage(const Stack& stack, const std::stop_token& stop) {
  FilledImage filled{stack.image, {}};
  std::vector<float>& voxels = filled.image.voxels;
  std::vector<std::uint8_t> known(voxels.size());
  bool all = true;
  for (std::size_t v = 0; v < voxels.size(); ++v) {
    known[v] = isKnown(stack, v);
    all = all && known[v];
  }
  if (all) return filled;
  const auto& n = filled.image.geometry.size;
  std::vector<std::int64_t> front, next;
  std::vector<std::uint8_t> reached = known;
  const auto neighbours = [&n](std::int64_t p, auto&& visit) {
    const std::int64_t i = p % n[0], j = p / n[0] % n[1], k = p / (n[0] * n[1]);
    if (k > 0) visit(p - n[0] * n[1]);
    if (k + 1 < n[2]) visit(p + n[0] * n[1]);
    if (i > 0) visit(p - 1);
    if (i + 1 < n[0]) visit(p + 1);
    if (j > 0) visit(p - n[0]);
    if (j + 1 < n[1]) visit(p + n[0]);
  };
  for (std::int64_t v = 0; v < static_cast<std::int64_t>(voxels.size()); ++v) {
    bool border = false;
    if (known[v]) neighbours(v, [&](std::int64_t q) { border = border || !known[q]; });
    if (border) front.push_back(v);
  }
  while (!front.empty()) {
    throwIfStopped(stop);
    next.clear();
    for (const std::int64_t p : front)
      neighbours(p, [&](std::int64_t q) {
        if (reached[q]) return;
        reached[q] = 1;
        voxels[q] = voxels[p];
        next.push_back(q);
      });
    front.swap(next);
  }
  filled.known = std::move(known);
  return filled;
}

} // namespace innergs
