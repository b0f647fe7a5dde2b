#pragma once
#include "Core/Features/FeatureModel.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// The classes of each block, as lists.
class SupportLists {
public:
  explicit SupportLists(const ClassSupport& support) {
    const std::int64_t blocks = support.blocks.voxelCount();
    start_.push_back(0);
    for (std::int64_t b = 0; b < blocks; ++b) {
      for (int c = 0; c < 32 * support.words; ++c)
        if (support.has(b, c)) classes_.push_back(static_cast<std::uint16_t>(c));
      most_ = std::max(most_, classes_.size() - start_.back());
      start_.push_back(classes_.size());
    }
  }
  std::span<const std::uint16_t> of(std::int64_t block) const {
    const auto b = static_cast<std::size_t>(block);
    return {classes_.data() + start_[b], start_[b + 1] - start_[b]};
  }
  std::size_t longest() const { return most_; }
  std::int64_t blocks() const { return static_cast<std::int64_t>(start_.size()) - 1; }

private:
  std::vector<std::uint16_t> classes_;
  std::vector<std::size_t> start_;
  std::size_t most_ = 0;
};

} // namespace innergs
