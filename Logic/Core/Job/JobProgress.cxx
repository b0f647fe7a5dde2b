#include "Core/Job/JobProgress.h"

#include "Core/Base/Elapsed.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr double kLittle = 0.02; // of what then remained

} // namespace

double remainingSeconds(const JobTime& since, const JobTime& now) {
  const double done = now.fraction - since.fraction, left = 1 - now.fraction;
  return done > kLittle * (1 - since.fraction) ? (now.elapsed - since.elapsed) * left / done : 0;
}

double JobProgress::elapsed() const {
  return secondsSince(start_);
}

void JobProgress::report(Phase phase, double fraction) {
  state.phase = phase;
  state.fraction = std::max(state.fraction, fraction);
  state.elapsed = elapsed();
  state.remaining = remainingSeconds(since_, {state.fraction, state.elapsed});
  if (callback_) callback_(state);
}

void JobProgress::say(const std::string& sentence) {
  state.note = sentence;
  report(state.phase, state.fraction);
  state.note.clear();
}

} // namespace innergs
