#include "Evaluation/Gaps.h"

#include "Core/Base/Error.h"

namespace innergs {

FilledStack fillGaps(const Stack& stack, const std::stop_token& stop) {
  FilledStack result{stack.image, {}};
  auto& voxels = result.image.voxels;
  std::vector<std::uint8_t> reached(voxels.size());
  bool complete = true;
  for (std::size_t p = 0; p < voxels.size(); ++p) {
    reached[p] = std::isfinite(voxels[p]) && (stack.observed.empty() || stack.observed[p]);
    complete = complete && reached[p];
  }
  if (complete) return result;
  result.known = reached;

  const auto& n = result.image.geometry.size;
  std::vector<std::int64_t> front, next;
  const auto neighbours = [&](std::int64_t p, auto&& visit) {
    const std::int64_t i = p % n[0], j = p / n[0] % n[1], k = p / (n[0] * n[1]);
    if (i > 0) visit(p - 1);
    if (i + 1 < n[0]) visit(p + 1);
    if (j > 0) visit(p - n[0]);
    if (j + 1 < n[1]) visit(p + n[0]);
    if (k > 0) visit(p - n[0] * n[1]);
    if (k + 1 < n[2]) visit(p + n[0] * n[1]);
  };
  for (std::size_t p = 0; p < voxels.size(); ++p)
    if (reached[p]) {
      bool border = false;
      neighbours(static_cast<std::int64_t>(p), [&](std::int64_t q) { border = border || !reached[q]; });
      if (border) front.push_back(static_cast<std::int64_t>(p));
    }
  while (!front.empty()) {
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "The interpolation was cancelled.");
    next.clear();
    for (std::int64_t p : front)
      neighbours(p, [&](std::int64_t q) {
        if (reached[q]) return;
        reached[q] = 1;
        voxels[q] = voxels[p];
        next.push_back(q);
      });
    front.swap(next);
  }
  return result;
}

} // namespace innergs
