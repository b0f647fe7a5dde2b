#pragma once
#include <cstdint>
#include <vector>

namespace innergs {

/// A division of a series' frames, to choose by how well the kept ones predict the held-out ones.
struct FrameFold {
  std::vector<std::int64_t> kept, heldOut;
  std::vector<double> keptTimes, heldOutTimes; // s
};

/// Holds out every fourth frame, from each of four offsets in turn, but never the first and last. Leaves out
/// folds that hold out none or keep fewer than two.
std::vector<FrameFold> frameFolds(const std::vector<double>& times);

} // namespace innergs
