#include "Core/Motion/RefinementState.h"

#include "Core/Base/Error.h"

#include <algorithm>

namespace innergs {

void RefinementOptimizer::start(std::int64_t gaussians, std::vector<AdamBlock> added) {
  canonical = Adam(gaussians);
  blocks = std::move(added);
  step = 0;
  mse = 0;
}

RefinementState RefinementOptimizer::state() const {
  RefinementState state;
  state.step = step;
  state.mse = mse;
  const auto append = [&](const std::vector<float>& values) {
    state.moments.insert(state.moments.end(), values.begin(), values.end());
  };
  append(canonical.moment1);
  append(canonical.moment2);
  for (const AdamBlock& block : blocks) {
    state.steps.push_back(block.steps);
    append(block.moment1);
    append(block.moment2);
  }
  return state;
}

void RefinementOptimizer::resume(const RefinementState& state) {
  std::size_t count = canonical.moment1.size() + canonical.moment2.size();
  for (const AdamBlock& block : blocks)
    count += block.moment1.size() + block.moment2.size();
  if (state.moments.size() != count || state.steps.size() != blocks.size() || state.step < 1 ||
      !std::all_of(state.steps.begin(), state.steps.end(),
                   [&](int done) { return done >= 0 && done <= state.step; }) ||
      !std::all_of(state.moments.begin(), state.moments.end(),
                   [](float x) { return x >= -1e30f && x <= 1e30f; }))
    throw Error(ErrorCode::FileFormat,
                "The state of the fit to resume is damaged: start again or from an earlier model.");
  step = state.step;
  mse = state.mse;
  auto at = state.moments.begin();
  const auto take = [&](std::vector<float>& values) {
    const auto end = at + static_cast<std::ptrdiff_t>(values.size());
    std::copy(at, end, values.begin());
    at = end;
  };
  take(canonical.moment1);
  take(canonical.moment2);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    blocks[b].steps = state.steps[b];
    take(blocks[b].moment1);
    take(blocks[b].moment2);
  }
}

void RefinementOptimizer::add(double error) {
  mse = step == 0 ? error : 0.95 * mse + 0.05 * error;
  ++step;
}

} // namespace innergs
