#include "Core/Fit/PlateauSchedule.h"

#include <algorithm>

namespace innergs {

void PlateauSchedule::add(double loss, const PlateauRule& rule) {
  if (loss < best_ * (1 - rule.threshold)) {
    best_ = loss;
    waited_ = 0;
  } else if (++waited_ >= rule.patience) {
    share_ = std::max(rule.lowest, share_ * rule.factor);
    waited_ = 0;
  }
}

} // namespace innergs
