#include "Core/Motion/FrameFolds.h"

#include <utility>

namespace innergs {

std::vector<FrameFold> frameFolds(const std::vector<double>& times) {
  constexpr std::int64_t kFolds = 4;
  const auto frames = static_cast<std::int64_t>(times.size());
  std::vector<FrameFold> folds;
  for (std::int64_t n = 0; n < kFolds; ++n) {
    FrameFold fold;
    for (std::int64_t f = 0; f < frames; ++f) {
      const bool out = f % kFolds == n && f > 0 && f + 1 < frames;
      (out ? fold.heldOut : fold.kept).push_back(f);
      (out ? fold.heldOutTimes : fold.keptTimes).push_back(times[f]);
    }
    if (!fold.heldOut.empty() && fold.kept.size() >= 2) folds.push_back(std::move(fold));
  }
  return folds;
}

} // namespace innergs
