#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"

#include <span>

namespace innergs {

/// Boxes around runs of a field's Gaussians, small where neighbours follow each other (inMortonOrder()), so
/// that grids which show few of them skip the others in runs. To be measured anew when Gaussians change.
class GaussianBlocks {
public:
  static constexpr std::int64_t kSize = 64; // Gaussians each; fewer in the last

  struct Block {
    Vec3 low, high; // of the means, model frame; infinite if any is not finite
    double scale;   // the largest
  };

  void measure(const GaussianField& field, ThreadPool& pool);
  std::span<const Block> all() const { return blocks_; }

private:
  std::vector<Block> blocks_;
};

} // namespace innergs
