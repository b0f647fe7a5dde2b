#include "Core/Render/GaussianBlocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {

void GaussianBlocks::measure(const GaussianField& field, ThreadPool& pool) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::int64_t kPerTask = 64;
  const std::int64_t count = (field.size() + kSize - 1) / kSize;
  blocks_.resize(static_cast<std::size_t>(count));
  pool.blocks(count, kPerTask, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t b = first; b < last; ++b) {
      Block block{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}, 0};
      float widest = -std::numeric_limits<float>::infinity();
      bool finite = true;
      for (std::int64_t i = b * kSize; i < std::min(field.size(), (b + 1) * kSize); ++i) {
        const Gaussian& g = field.gaussians[i];
        for (int a = 0; a < 3; ++a) {
          finite = finite && std::isfinite(g.mean[a]) && std::isfinite(g.logScale[a]);
          block.low[a] = std::min(block.low[a], static_cast<double>(g.mean[a]));
          block.high[a] = std::max(block.high[a], static_cast<double>(g.mean[a]));
          widest = std::max(widest, g.logScale[a]);
        }
      }
      block.scale = std::exp(static_cast<double>(widest));
      if (!finite)
        block = {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}, kInfinity};
      blocks_[b] = block;
    }
  });
}

} // namespace innergs
