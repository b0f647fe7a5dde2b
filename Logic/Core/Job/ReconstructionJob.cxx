#include "Core/Job/ReconstructionJob.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Failure.h"
#include "Core/Job/ProgressParts.h"
#include "Core/Job/ReconstructionRun.h"

#include <algorithm>
#include <utility>

namespace innergs {

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing:
    return "Preparing";
  case Phase::Aligning:
    return "Aligning scans and slices";
  case Phase::Predicting:
    return "Predicting between slices";
  case Phase::Initialising:
    return "Placing Gaussians";
  case Phase::Tracking:
    return "Tracking frames";
  case Phase::Fitting:
    return "Fitting";
  case Phase::Refining:
    return "Refining";
  case Phase::Rendering:
    return "Rendering";
  case Phase::Judging:
    return "Judging the quality (second fit)";
  case Phase::Done:
    return "Done";
  }
  return "";
}

struct ReconstructionJob::Impl {
  ReconstructionInput input;
  Settings settings;
  ProgressCallback progress;
  std::function<void(const Volume&)> preview;

  /// Measures the result's quality by a second fit with the same settings.
  void judge(ReconstructionResult& result, const ProgressCallback& told, const std::stop_token& stop);
};

ReconstructionJob::ReconstructionJob(ReconstructionInput input, Settings settings)
    : impl_(std::make_unique<Impl>()) {
  impl_->input = std::move(input);
  impl_->settings = std::move(settings);
}
ReconstructionJob::~ReconstructionJob() = default;
void ReconstructionJob::onProgress(ProgressCallback callback) {
  impl_->progress = std::move(callback);
}
void ReconstructionJob::onPreview(std::function<void(const Volume&)> callback) {
  impl_->preview = std::move(callback);
}
ReconstructionInput ReconstructionJob::takeInput() {
  return std::exchange(impl_->input, {});
}
ReconstructionResult ReconstructionJob::run(std::stop_token stop, bool renderWhenCancelled) {
  Impl& job = *impl_;
  const double fraction = job.input.heldOutFraction;
  checkHeldOutFraction(fraction);
  std::optional<ProgressParts> parts;
  if (fraction > 0) parts.emplace(job.progress, std::vector<double>{1, 1 - fraction});
  ReconstructionResult result =
      ReconstructionRun(job.input, job.settings, false, parts ? parts->next() : job.progress, job.preview)
          .run(stop, renderWhenCancelled);
  if (parts && !result.cancelled) {
    job.judge(result, parts->next(), stop);
    parts->finish();
  }
  return result;
}

void ReconstructionJob::Impl::judge(ReconstructionResult& result, const ProgressCallback& told,
                                    const std::stop_token& stop) {
  const auto begun = std::chrono::steady_clock::now();
  const auto fail = [&](const std::string& why) {
    result.judging = Judging::Failed;
    result.warnings.push_back("The quality could not be judged. " + why);
  };
  if (std::all_of(input.stacks.begin(), input.stacks.end(),
                  [](const Stack& stack) { return stack.image.geometry.size[2] < 3; }))
    return fail("A scan needs at least three slices for one of them to be withheld.");
  const auto resume = std::exchange(input.resume, nullptr); // it has seen the slices to be withheld
  Failure failure;
  ReconstructionResult found;
  try {
    found = ReconstructionRun(input, settings, true, told).run(stop, false);
  } catch (...) {
    failure = failureOf();
  }
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
