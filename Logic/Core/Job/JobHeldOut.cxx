#include "Core/Base/Failure.h"
#include "Core/Job/JobSteps.h"

#include <utility>

/// The judging of a reconstruction's quality by a second fit, on slices that this one does not see.
namespace innergs {

void ReconstructionJob::Impl::scoreHeldOut(const PreparedInput& prepared, const GaussianField& field,
                                           const RenderOptions& options, ReconstructionResult& result) const {
  double squared = 0;
  std::int64_t count = 0;
  for (std::size_t s = 0; s < prepared.stacks.size(); ++s) {
    if (prepared.heldOut[s].empty()) continue;
    const Stack& whole = input.stacks[s];
    const auto& scored = prepared.scored[s];
    const Volume rendered = renderStack(field, whole, options);
    const std::int64_t plane = whole.image.geometry.size[0] * whole.image.geometry.size[1];
    for (std::int64_t k : prepared.heldOut[s]) {
      const std::int64_t before = count;
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
        const float truth = whole.image.voxels[v];
        if (!std::isfinite(truth) || (!scored.empty() && !scored[v])) continue;
        const double e = (rendered.voxels[v] - truth) / field.intensityScale;
        squared += e * e;
        ++count;
      }
      result.heldOutSlices += count > before;
    }
  }
  if (count > 0) result.heldOutPsnr = psnrOf(squared / static_cast<double>(count));
}

void ReconstructionJob::Impl::judge(ReconstructionResult& result, const Settings& asked,
                                    const ProgressCallback& told, const std::stop_token& stop) {
  const auto begun = std::chrono::steady_clock::now();
  const auto fail = [&](const std::string& why) {
    result.judging = Judging::Failed;
    result.warnings.push_back("The quality could not be judged. " + why);
  };
  device.reset();
  if (std::all_of(input.stacks.begin(), input.stacks.end(),
                  [](const Stack& stack) { return stack.image.geometry.size[2] < 3; }))
    return fail("A scan needs three slices at least for one of them to be withheld.");
  Impl second;
  second.withheld = true;
  second.settings = asked;
  second.progress = told;
  const auto resume = std::exchange(input.resume, nullptr); // has seen what is to be withheld
  second.input = std::move(input);
  Failure failure;
  ReconstructionResult found;
  try {
    found = second.run(stop, false);
  } catch (...) {
    failure = failureOf();
  }
  input = std::move(second.input);
  input.resume = resume;
  if (!failure.sentence.empty()) {
    fail(failure.sentence);
  } else if (found.cancelled) {
    result.judging = Judging::Stopped;
    result.warnings.push_back("The judging of the quality was stopped: the result itself is complete.");
  } else if (found.heldOutSlices == 0) {
    fail("The slices withheld for it show nothing inside the mask.");
  } else {
    result.judging = Judging::Done;
    result.heldOutPsnr = found.heldOutPsnr;
    result.heldOutSlices = found.heldOutSlices;
  }
  result.judgingSeconds = secondsSince(begun);
  result.seconds += result.judgingSeconds;
}

} // namespace innergs
