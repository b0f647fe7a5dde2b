#pragma once
#include <cstdint>
#include <vector>

namespace innergs {

/// A division of a series' frames, to choose by how well the kept ones predict the withheld ones.
struct FrameFold {
  std::vector<std::int64_t> kept, withheld;
  std::vector<double> keptTimes, withheldTimes; // s
};

/// Withholds every fourth frame, from each of four offsets in turn, but never the first and last. Leaves out
/// folds that withhold none or keep fewer than two.
std::vector<FrameFold> frameFolds(const std::vector<double>& times);

} // namespace innergs
