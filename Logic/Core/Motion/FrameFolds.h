#pragma once
#include <cstdint>
#include <vector>

namespace innergs {

/// A division of a series' frames to choose by: how well those kept predict those withheld.
struct FrameFold {
  std::vector<std::int64_t> kept, withheld;
  std::vector<double> keptTimes, withheldTimes; // s
};

/// Withholds every fourth frame, all quarters in turn, and never the first and last. Leaves out folds that
/// withhold none or keep fewer than two.
std::vector<FrameFold> frameFolds(const std::vector<double>& times);

} // namespace innergs
