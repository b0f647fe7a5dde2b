#include "Core/Job/ProgressParts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace innergs {

ProgressParts::ProgressParts(ProgressCallback callback, std::vector<double> weights)
    : callback_(std::move(callback)), weights_(std::move(weights)) {}

ProgressCallback ProgressParts::next(Phase phase) {
  phase_ = phase;
  if (begun_ > 0) {
    weightBefore_ += weights_[current_];
    elapsedBefore_ = last_.elapsed;
  }
  if (begun_ == 1) first_ = last_;
  current_ = begun_++;
  return [this](const Progress& part) { report(part); };
}

void ProgressParts::report(const Progress& part) {
  const double all = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  const double weight = weights_[current_], later = all - weightBefore_ - weight;
  if (current_ > 0 && phase_ == Phase::Judging && !std::isnan(part.heldOutPsnr))
    first_.heldOutPsnr = part.heldOutPsnr;
  Progress whole = current_ == 0 ? part : first_;
  if (current_ > 0) {
    whole.phase = phase_;
    whole.iteration = part.iteration;
    whole.iterations = part.iterations;
    whole.note.clear(); // only the delivered fit reports where it runs
  } else if (part.phase == Phase::Done && later > 0) {
    whole.phase = last_.phase;
  }
  const bool known = part.remaining > 0 || part.fraction >= 1;
  const double perWeight = known               ? (part.elapsed + part.remaining) / weight
                           : weightBefore_ > 0 ? elapsedBefore_ / weightBefore_
                                               : 0;
  whole.fraction = (weightBefore_ + weight * std::clamp(part.fraction, 0.0, 1.0)) / all;
  whole.fraction = std::max(whole.fraction, last_.fraction);
  whole.elapsed = elapsedBefore_ + part.elapsed;
  whole.remaining = (known ? part.remaining : perWeight * weight * (1 - part.fraction)) + perWeight * later;
  last_ = whole;
  last_.note.clear();
  if (callback_) callback_(whole);
}

void ProgressParts::finish() {
  Progress done = begun_ > 1 ? first_ : last_;
  done.phase = Phase::Done;
  done.fraction = 1;
  done.elapsed = last_.elapsed;
  done.remaining = 0;
  if (callback_) callback_(done);
}

} // namespace innergs
