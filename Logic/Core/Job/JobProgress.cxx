#include "Core/Job/JobProgress.h"

#include "Core/Base/Elapsed.h"

#include <algorithm>

namespace innergs {

double JobProgress::elapsed() const {
  return secondsSince(start_);
}

void JobProgress::report(Phase phase, double fraction) {
  state.phase = phase;
  state.fraction = std::max(state.fraction, fraction);
  state.elapsed = elapsed();
  state.remaining = state.fraction > 0.02 ? state.elapsed * (1 - state.fraction) / state.fraction : 0;
  if (callback_) callback_(state);
}

void JobProgress::say(const std::string& sentence) {
  state.note = sentence;
  report(state.phase, state.fraction);
  state.note.clear();
}

} // namespace innergs
