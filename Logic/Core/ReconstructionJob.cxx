#include "Core/ReconstructionJob.h"

#include "Core/Error.h"
#include "Core/JobInput.h"
#include "Core/Metrics.h"
#include "Core/Plan.h"
#include "Core/Render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kFitStarts = 0.05, kFitEnds = 0.93; // of the progress bar

std::string settingsKey(const Settings& s, const std::string& fingerprint) {
  const auto number = [](double x) { return std::to_string(x); };
  return "preset " + std::to_string(static_cast<int>(s.preset)) + ", blending " + std::to_string(static_cast<int>(s.blending)) +
         ", linear " + std::to_string(s.linearIntensity.value_or(false)) + ", start " +
         std::to_string(static_cast<int>(s.initialisation)) + ", loss " + std::to_string(static_cast<int>(s.loss)) + " " +
         number(s.huberDelta) + " " + number(s.ssimWeight) + ", gaussians " + std::to_string(s.gaussians.value_or(0)) +
         ", iterations " + std::to_string(s.iterations.value_or(0)) + ", stop rule " + std::to_string(s.paperStopRule) +
         ", relocate " + std::to_string(s.relocate) + ", seed " + std::to_string(s.seed) + ", input " + fingerprint;
}

double psnrOf(double mse) { return mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity(); }

/// The lattice reduced so that no axis has more than `most` voxels.
GridGeometry reduced(const GridGeometry& g, std::int64_t most) {
  Vec3 spacing = g.spacing;
  for (int a = 0; a < 3; ++a)
    spacing[a] *= std::max(1.0, static_cast<double>(g.size[a]) / static_cast<double>(most));
  return withSpacing(g, spacing);
}

} // namespace

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing: return "Preparing";
  case Phase::Initialising: return "Placing Gaussians";
  case Phase::Fitting: return "Fitting";
  case Phase::Refining: return "Refining";
  case Phase::Rendering: return "Rendering";
  case Phase::Done: return "Done";
  }
  return "";
}

struct ReconstructionJob::Impl {
  ReconstructionInput input;
  Settings settings;
  ProgressCallback progress;
  std::function<void(const Volume&)> preview;

  Clock::time_point start;
  Progress state;
  double nextPreview = 1.0;

  void report(Phase phase, double fraction) {
    state.phase = phase;
    state.fraction = std::max(state.fraction, fraction);
    state.elapsed = since(start);
    state.remaining = state.fraction > 0.02 ? state.elapsed * (1 - state.fraction) / state.fraction : 0;
    if (progress) progress(state);
  }

  RenderOptions renderOptions(std::stop_token stop) const {
    RenderOptions options;
    options.threads = settings.threads;
    options.instructionSet = settings.instructionSet;
    options.stop = std::move(stop);
    return options;
  }

  ReconstructionResult run(std::stop_token stop, bool renderWhenCancelled);
  std::unique_ptr<Trainer> makeTrainer(const PreparedInput& prepared, const KernelSet& kernels, ThreadPool& pool,
                                       ReconstructionResult& result);
  void fit(Trainer& trainer, const GridGeometry& grid, std::stop_token stop);
  double heldOutPsnr(const PreparedInput& prepared, const GaussianField& field, std::stop_token stop) const;
};

ReconstructionJob::ReconstructionJob(ReconstructionInput input, Settings settings) : impl_(std::make_unique<Impl>()) {
  impl_->input = std::move(input);
  impl_->settings = std::move(settings);
}
ReconstructionJob::~ReconstructionJob() = default;
void ReconstructionJob::onProgress(ProgressCallback callback) { impl_->progress = std::move(callback); }
void ReconstructionJob::onPreview(std::function<void(const Volume&)> callback) { impl_->preview = std::move(callback); }
ReconstructionResult ReconstructionJob::run(std::stop_token stop, bool renderWhenCancelled) {
  return impl_->run(std::move(stop), renderWhenCancelled);
}

std::unique_ptr<Trainer> ReconstructionJob::Impl::makeTrainer(const PreparedInput& prepared, const KernelSet& kernels,
                                                              ThreadPool& pool, ReconstructionResult& result) {
  const IntensityMap map = chooseIntensityMap(prepared.stacks);
  const DataTraits traits = measureTraits(prepared.stacks, map);
  result.noise = traits.noise * map.scale;
  const FitPlan plan = makePlan(settings, traits);
  result.settings = settings;
  const std::string key = settingsKey(settings, prepared.fingerprint);
  const Checkpoint* resume = input.resume.get();
  const bool same = resume && resume->settingsKey == key;

  GaussianField field;
  field.blending = settings.blending;
  field.linearIntensity = plan.linearIntensity;
  field.modelToWorld = modelFrame(prepared.stacks.front().image.geometry);
  field.intensityScale = map.scale;
  field.intensityOffset = map.offset;
  field.cutoff = plan.cutoffEarly;
  if (resume) {
    checkField(resume->field);
    field = resume->field;
    if (!same)
      result.warnings.push_back("The model to resume was made with other settings or images: its Gaussians are the start of a new fit.");
  } else {
    report(Phase::Initialising, 0.02);
    const ProxyVolume proxy = makeProxy(prepared.stacks, field.modelToWorld, map, traits.voxel, pool);
    initialise(field, proxy, plan.start, settings.seed, pool);
    if (field.gaussians.empty())
      throw Error(ErrorCode::NoData, "No Gaussian could be placed: the images observe no voxel of their own grid.");
  }
  field.domain = prepared.outputGrid;
  std::vector<Observation> observations;
  const IntensityMap fieldMap{field.intensityScale, field.intensityOffset};
  const bool closedForm = field.blending == Blending::Additive && !field.linearIntensity;
  for (const Stack& stack : prepared.stacks)
    for (Observation& o : observe(stack, field.modelToWorld, fieldMap, closedForm)) {
      pool.throwIfStopped();
      observations.push_back(std::move(o));
    }
  auto trainer =
      std::make_unique<Trainer>(std::move(field), std::move(observations), plan, kernels, pool, settings.seed);
  if (same && resume->moment1.empty())
    trainer->restore(trainer->adam().moment1, trainer->adam().moment2, resume->iteration);
  else if (same)
    trainer->restore(resume->moment1, resume->moment2, resume->iteration);
  return trainer;
}

void ReconstructionJob::Impl::fit(Trainer& trainer, const GridGeometry& grid, std::stop_token stop) {
  const auto begun = Clock::now();
  state.iterations = *settings.iterations;
  state.gaussians = trainer.field().size();
  while (trainer.step()) {
    state.iteration = trainer.iteration();
    state.loss = trainer.loss();
    state.trainingPsnr = psnrOf(trainer.mse());
    const double share = static_cast<double>(state.iteration) / std::max(1, state.iterations);
    report(Phase::Fitting, kFitStarts + (kFitEnds - kFitStarts) * share);
    if (preview && since(start) >= nextPreview && !stop.stop_requested()) {
      preview(render(trainer.field(), reduced(grid, 96), renderOptions(stop)));
      nextPreview = since(start) + std::max(2.0, 0.1 * since(begun));
    }
  }
}

double ReconstructionJob::Impl::heldOutPsnr(const PreparedInput& prepared, const GaussianField& field,
                                            std::stop_token stop) const {
  double squared = 0;
  std::int64_t count = 0;
  for (std::size_t s = 0; s < prepared.stacks.size(); ++s) {
    if (prepared.heldOut[s].empty()) continue;
    const Stack& withheld = input.stacks[s];
    const Volume rendered = renderStack(field, withheld, renderOptions(stop));
    const std::int64_t plane = withheld.image.geometry.size[0] * withheld.image.geometry.size[1];
    for (std::int64_t k : prepared.heldOut[s])
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
        const float truth = withheld.image.voxels[v];
        if (!std::isfinite(truth) || (!withheld.observed.empty() && !withheld.observed[v])) continue;
        const double e = (rendered.voxels[v] - truth) / field.intensityScale;
        squared += e * e;
        ++count;
      }
  }
  return count ? psnrOf(squared / static_cast<double>(count)) : kNaN;
}

ReconstructionResult ReconstructionJob::Impl::run(std::stop_token stop, bool renderWhenCancelled) {
  start = Clock::now();
  state = {};
  state.heldOutPsnr = kNaN;
  nextPreview = 1.0;
  checkSettings(settings);
  const KernelSet& kernels = kernelSet(settings.instructionSet);
  report(Phase::Preparing, 0);
  ReconstructionResult result;
  result.instructionSet = kernels.name;
  result.heldOutPsnr = kNaN;
  const PreparedInput prepared = prepareInput(input);
  result.nonFiniteVoxels = prepared.nonFinite;
  result.warnings = prepared.warnings;
  const std::int64_t needed = estimateMemory(input, settings), available = availableMemory();
  if (available > 0 && needed > available)
    throw Error(ErrorCode::Memory, "The reconstruction needs about " + std::to_string(needed / 1000000) + " MB of memory and " +
                                       std::to_string(available / 1000000) +
                                       " MB are available: choose a smaller region, a coarser output or fewer Gaussians.");
  ThreadPool pool(settings.threads);
  pool.setStop(stop);
  std::unique_ptr<Trainer> trainer;
  try {
    trainer = makeTrainer(prepared, kernels, pool, result);
    const auto begun = Clock::now();
    fit(*trainer, prepared.outputGrid, stop);
    result.fitSeconds = since(begun);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    result.settings = settings;
  }
  auto checkpoint = std::make_shared<Checkpoint>();
  if (trainer) {
    result.trainingPsnr = trainer->mse() > 0 || trainer->loss() > 0 ? psnrOf(trainer->mse()) : kNaN;
    result.iterations = trainer->iteration();
    checkpoint->field = trainer->field();
    checkpoint->iteration = trainer->iteration();
    checkpoint->settingsKey = settingsKey(settings, prepared.fingerprint);
    if (result.cancelled) {
      checkpoint->moment1 = trainer->adam().moment1;
      checkpoint->moment2 = trainer->adam().moment2;
    }
    trainer.reset();
  }
  result.checkpoint = checkpoint;
  if (!checkpoint->field.gaussians.empty() && (!result.cancelled || renderWhenCancelled)) {
    try {
      const std::stop_token token = result.cancelled ? std::stop_token{} : stop;
      report(Phase::Rendering, kFitEnds);
      result.volume = render(checkpoint->field, prepared.outputGrid, renderOptions(token));
      result.heldOutPsnr = heldOutPsnr(prepared, checkpoint->field, token);
      state.heldOutPsnr = result.heldOutPsnr;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Cancelled) throw;
      result.cancelled = true;
    }
  }
  result.seconds = since(start);
  if (!result.cancelled) report(Phase::Done, 1);
  return result;
}

} // namespace innergs
