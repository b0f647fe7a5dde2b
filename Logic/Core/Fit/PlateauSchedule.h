#pragma once
#include "Core/Settings/Settings.h"

#include <limits>

namespace innergs {

/// Reduces the learning rates when the loss stops improving: a function of the losses so far.
class PlateauSchedule {
public:
  void add(double loss, const PlateauRule& rule);
  double share() const { return share_; } // of the initial rates

private:
  double best_ = std::numeric_limits<double>::infinity(), share_ = 1;
  int waited_ = 0;
};

} // namespace innergs
