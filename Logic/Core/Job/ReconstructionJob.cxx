#include "Core/Job/ReconstructionJob.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Image/Metrics.h"
#include "Core/Job/JobSteps.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/TimeEstimate.h"

#include <atomic>
#include <utility>

namespace innergs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::atomic<int> running{0};

struct Running {
  Running() { ++running; }
  ~Running() { --running; }
};

} // namespace

int runningJobs() {
  return running;
}

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing:
    return "Preparing";
  case Phase::Predicting:
    return "Predicting between slices";
  case Phase::Initialising:
    return "Placing Gaussians";
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
  checkHeldOutFraction(impl_->input.heldOutFraction);
  const double fraction = impl_->input.heldOutFraction;
  if (fraction == 0) return impl_->run(std::move(stop), renderWhenCancelled);
  const Settings asked = impl_->settings; // those that a fit finds are not the second one's
  const struct Restored {
    Impl& impl;
    ProgressCallback told = std::exchange(impl.progress, {});
    ~Restored() { impl.progress = told; }
  } progress{*impl_};
  ProgressParts parts(progress.told, {1, 1 - fraction});
  impl_->progress = parts.next();
  ReconstructionResult result = impl_->run(stop, renderWhenCancelled);
  if (!result.cancelled) {
    impl_->judge(result, asked, parts.next(), stop);
    parts.finish();
  }
  return result;
}

void ReconstructionJob::Impl::addResidual(const PreparedInput& prepared, ThreadPool& pool,
                                          ReconstructionResult& result) {
  if (predicted) return keepPrediction(prepared, pool, result);
  GaussianField& field = model.field;
  if (!settings.consistency || traits.thickness <= 0) return;
  if (std::any_of(prepared.stacks.begin(), prepared.stacks.end(),
                  [](const Stack& s) { return !s.poses.empty(); }))
    return;
  report(Phase::Refining, kFitEnds);
  RenderOptions options = renderOptions(field, pool.stopToken());
  options.bounded = false;
  Volume volume = render(field, field.region(), options);
  const std::vector<float> before = volume.voxels;
  BackProjectionPlan refinement;
  refinement.noise = result.noise;
  refinement.range = prepared.range;
  const double rms = backProject(volume, prepared.stacks, refinement, pool);
  for (std::size_t v = 0; v < before.size(); ++v)
    volume.voxels[v] = static_cast<float>((volume.voxels[v] - before[v]) / field.intensityScale);
  if (std::any_of(volume.voxels.begin(), volume.voxels.end(), [](float x) { return x != 0; }))
    field.residual = std::move(volume);
  result.trainingPsnr = state.trainingPsnr =
      psnrOf(rms * rms / (field.intensityScale * field.intensityScale));
}

ReconstructionResult ReconstructionJob::Impl::run(std::stop_token stop, bool renderWhenCancelled) {
  const Running counted;
  start = std::chrono::steady_clock::now();
  state = {};
  nextPreview = 1.0;
  refitting = false;
  checkSettings(settings);
  const KernelSet& kernels = kernelSet(settings.instructionSet, settings.selection);
  device.emplace(settings.device, settings.instructionSet, settings.selection);
  report(Phase::Preparing, 0);
  ReconstructionResult result;
  result.device = device->use;
  result.instructionSet = kernels.name;
  for (const Stack& stack : input.stacks)
    checkStack(stack);
  if (!withheld) // before the first fit, for both
    if (const std::string refusal = memoryRefusal(estimateMemory(input, settings), availableMemory());
        !refusal.empty())
      throw Error(ErrorCode::Memory, refusal);
  PreparedInput prepared;
  try {
    prepared = prepareInput(input, stop, withheld);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    result.settings = settings;
    result.trainingPsnr = kNaN;
    // What was given is what was reached; without its volume it counts as nothing.
    result.model = input.resume && !renderWhenCancelled ? input.resume : std::make_shared<const Model>();
    result.iterations = result.model->iteration;
    result.seconds = secondsSince(start);
    return result;
  }
  result.nonFiniteVoxels = prepared.nonFinite;
  result.warnings = prepared.warnings;
  ThreadPool pool(settings.threads);
  result.threads = pool.threads();
  pool.setStop(stop);
  model = input.resume ? *input.resume : Model{};
  result.iterations = model.iteration;
  result.settings = settings;
  result.trainingPsnr = kNaN;
  std::optional<std::chrono::steady_clock::time_point> begun; // the fit, until it has ended
  const auto endFit = [&] {
    result.iterations = model.iteration;
    if (begun) result.fitSeconds = secondsSince(*begun);
    begun.reset();
  };
  try {
    choose(prepared, pool, result);
    begun = std::chrono::steady_clock::now();
    fit(prepared, kernels, pool, result);
    endFit();
    addResidual(prepared, pool, result);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    endFit();
  }
  const GaussianField& field = model.field;
  const auto finish = [&](const std::stop_token& token) {
    report(Phase::Rendering, kResidualEnds);
    const RenderOptions options = renderOptions(field, token);
    result.volume = render(field, prepared.outputGrid, options);
    if (!withheld) return;
    scoreHeldOut(prepared, field, options, result);
    state.heldOutPsnr = result.heldOutPsnr;
  };
  if (!result.cancelled) {
    try {
      finish(stop);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Cancelled) throw;
      result.cancelled = true;
      result.volume = {};
    }
  }
  if (result.cancelled && renderWhenCancelled && !field.gaussians.empty()) finish({});
  result.model = std::make_shared<const Model>(std::move(model));
  result.seconds = secondsSince(start);
  const bool goesOn = input.resume && !refitting && !input.resume->field.gaussians.empty();
  result.iterationsRun = std::max(0, result.iterations - (goesOn ? input.resume->iteration : 0));
  rememberSpeed(input, result);
  if (!result.cancelled) report(Phase::Done, 1);
  return result;
}

} // namespace innergs
