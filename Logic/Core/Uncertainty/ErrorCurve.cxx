#include "Core/Uncertainty/ErrorCurve.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {

double quantile(std::vector<float>& numbers, double share) {
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto n = static_cast<std::ptrdiff_t>(share * static_cast<double>(numbers.size() - 1));
  std::nth_element(numbers.begin(), numbers.begin() + n, numbers.end());
  return numbers[static_cast<std::size_t>(n)];
}

ErrorCurve::ErrorCurve(std::vector<HeldOutError> seen, int bins) {
  if (seen.empty()) return;
  std::stable_sort(seen.begin(), seen.end(),
                   [](const HeldOutError& a, const HeldOutError& b) { return a.detail < b.detail; });
  const std::size_t count = std::clamp<std::size_t>(seen.size() / 50, 1, static_cast<std::size_t>(bins));
  struct Block {
    double detail, deviation;
    int bins;
  };
  std::vector<Block> blocks;
  std::vector<float> errors;
  std::vector<double> centre;
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t from = b * seen.size() / count, to = (b + 1) * seen.size() / count;
    errors.clear();
    double sum = 0;
    for (std::size_t n = from; n < to; ++n) {
      errors.push_back(std::abs(seen[n].error));
      sum += seen[n].detail;
    }
    centre.push_back(sum / static_cast<double>(to - from));
    blocks.push_back({centre.back(), quantile(errors, 0.9) / kNinety, 1});
    while (blocks.size() > 1 && blocks.back().deviation < blocks[blocks.size() - 2].deviation) {
      const Block last = blocks.back();
      blocks.pop_back();
      Block& before = blocks.back();
      const int both = before.bins + last.bins;
      before.deviation = (before.deviation * before.bins + last.deviation * last.bins) / both;
      before.bins = both;
    }
  }
  std::size_t bin = 0;
  for (const Block& block : blocks)
    for (int n = 0; n < block.bins; ++n, ++bin) {
      if (!detail_.empty() && centre[bin] <= detail_.back()) continue;
      detail_.push_back(centre[bin]);
      deviation_.push_back(block.deviation);
    }
}

double ErrorCurve::at(double detail) const {
  if (detail_.empty()) return std::numeric_limits<double>::quiet_NaN();
  if (!(detail > detail_.front())) return deviation_.front();
  if (detail >= detail_.back()) return deviation_.back();
  const auto above = std::upper_bound(detail_.begin(), detail_.end(), detail) - detail_.begin();
  const double share = (detail - detail_[above - 1]) / (detail_[above] - detail_[above - 1]);
  return deviation_[above - 1] + share * (deviation_[above] - deviation_[above - 1]);
}

} // namespace innergs
