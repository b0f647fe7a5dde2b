#include "Core/ReconstructionJob.h"

#include "Core/BackProjection.h"
#include "Core/DevicePlugin.h"
#include "Core/Error.h"
#include "Core/JobInput.h"
#include "Core/Metrics.h"
#include "Core/Plan.h"
#include "Core/Render.h"
#include "Core/Resume.h"
#include "Core/TimeEstimate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kReportEvery = 0.05; // seconds, at least, while a device sweeps
constexpr double kFitStarts = 0.03, kFitEnds = 0.92, kDetailEnds = 0.97; // of the progress bar

std::string gigabytes(std::int64_t bytes) {
  char text[64];
  std::snprintf(text, sizeof text, "%.2g GB", static_cast<double>(bytes) * 1e-9);
  return text;
}

double psnrOf(double mse) {
  return mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity();
}
double psnrOf(const LossSum& sum) {
  return psnrOf(sum.squared / static_cast<double>(std::max<std::int64_t>(1, sum.samples)));
}

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
  case Phase::Preparing:
    return "Preparing";
  case Phase::Initialising:
    return "Placing Gaussians";
  case Phase::Fitting:
    return "Fitting";
  case Phase::Refining:
    return "Refining";
  case Phase::Rendering:
    return "Rendering";
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

  /// A report that says where the fit runs.
  void reportDevice(Phase phase) {
    state.note = device->use.reason;
    report(phase, state.fraction);
    state.note.clear();
  }

  RenderOptions renderOptions(const GaussianField& field, std::stop_token stop) const {
    RenderOptions options;
    options.threads = settings.threads;
    options.instructionSet = settings.instructionSet;
    options.selection = settings.selection;
    options.stop = std::move(stop);
    options.device = device->makeField(field);
    return options;
  }

  ReconstructionResult run(std::stop_token stop, bool renderWhenCancelled);
  void choose(const PreparedInput& prepared, const ThreadPool& pool, ReconstructionResult& result);
  GaussianField startField(const PreparedInput& prepared, int member, ThreadPool& pool);
  void fit(const PreparedInput& prepared, const KernelSet& kernels, ThreadPool& pool,
           ReconstructionResult& result);
  std::unique_ptr<FitDevice> place(const FitRequest& request, ReconstructionResult& result);
  void noticeFailure(const Trainer& trainer, int before, ReconstructionResult& result);
  void sweep(Trainer& trainer, const GridGeometry& grid, int before, ThreadPool& pool,
             ReconstructionResult& result);
  void addDetail(const PreparedInput& prepared, ThreadPool& pool, ReconstructionResult& result);
  double heldOutPsnr(const PreparedInput& prepared, const GaussianField& field,
                     const RenderOptions& options) const;

  /// A model to resume that was stopped after its first Gaussians and by another fit than this one.
  bool refits() const {
    return input.resume && !input.resume->field.gaussians.empty() && input.resume->settingsKey != key;
  }

  IntensityMap map;
  DataTraits traits;
  FitPlan plan;
  std::optional<DeviceChoice> device;
  std::string key;
  bool refitting = false; // the model to resume is the start of another fit
  Checkpoint checkpoint;  // of this run; its field holds the finished members
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
  return impl_->run(std::move(stop), renderWhenCancelled);
}

void ReconstructionJob::Impl::choose(const PreparedInput& prepared, const ThreadPool& pool,
                                     ReconstructionResult& result) {
  pool.throwIfStopped();
  map = chooseIntensityMap(prepared.stacks);
  pool.throwIfStopped();
  traits = measureTraits(prepared.stacks, map);
  const Settings asked = settings;
  plan = makePlan(settings, traits);
  key = settingsKey(settings, prepared.fingerprint);
  if (refits()) { // one field to refit, as it is: further members would start in another frame
    settings = asked;
    settings.members = 1;
    settings.blending = input.resume->field.blending;
    settings.linearIntensity = input.resume->field.linearIntensity;
    plan = makePlan(settings, traits);
    key = settingsKey(settings, prepared.fingerprint);
    refitting = true;
  }
  result.noise = traits.noise * map.scale;
  result.settings = settings;
}

GaussianField ReconstructionJob::Impl::startField(const PreparedInput& prepared, int member,
                                                  ThreadPool& pool) {
  GaussianField field;
  field.blending = *settings.blending;
  field.linearIntensity = plan.linearIntensity;
  field.modelToWorld = modelFrame(prepared.stacks.front().image.geometry);
  field.intensityScale = map.scale;
  field.intensityOffset = map.offset;
  field.cutoff = plan.cutoff;
  field.domain = dataDomain(prepared.stacks);
  const ProxyVolume proxy = makeProxy(prepared.stacks, field.modelToWorld, map, traits.voxel, pool);
  initialise(field, proxy, plan.start, settings.seed + static_cast<std::uint64_t>(member), pool);
  if (field.gaussians.empty())
    throw Error(ErrorCode::NoData,
                "No Gaussian could be placed: the images observe no voxel of their own grid.");
  return field;
}

void ReconstructionJob::Impl::fit(const PreparedInput& prepared, const KernelSet& kernels, ThreadPool& pool,
                                  ReconstructionResult& result) {
  const Checkpoint* resume = input.resume.get();
  if (resume && resume->field.gaussians.empty()) resume = nullptr; // stopped before its first Gaussians
  const bool same = resume && !refitting;
  const int members = *settings.members, perMember = *settings.iterations;
  state.iterations = members * perMember;
  int member = same ? resume->iteration / perMember : 0;
  GaussianField field, merged;
  bool complete = false; // only detail and volume are to be made again
  if (resume) {
    checkField(resume->field);
    field = resume->field;
    field.detail = {};
    field.domain = dataDomain(prepared.stacks);
    if (!same)
      result.warnings.push_back("The model to resume was made with other settings or images: its Gaussians "
                                "are the start of a new fit.");
  }
  if (same) {
    checkResumable(*resume, state.iterations);
    checkpoint = *resume; // stopped before anything is done: what was given
    checkpoint.field.domain = field.domain;
    checkpoint.field.detail = {};
    complete = resume->moment1.empty() && resume->iteration > (members - 1) * perMember;
  }
  if (same && !complete) {
    const auto open = field.gaussians.begin() + resume->finished;
    merged = field;
    merged.gaussians.assign(field.gaussians.begin(), open);
    field.gaussians.erase(field.gaussians.begin(), open);
  }
  if (field.gaussians.empty()) {
    report(Phase::Initialising, 0.02);
    field = startField(prepared, member, pool);
  }
  if (!same) {
    merged = field;
    merged.gaussians.clear();
  }
  std::vector<Observation> observations;
  const bool closedForm = field.blending == Blending::Additive && !field.linearIntensity;
  for (const Stack& stack : prepared.stacks)
    for (int axis = 2; axis >= (plan.allAxes ? 0 : 2); --axis)
      for (Observation& o :
           observe(withSliceAxis(stack, axis), field.modelToWorld,
                   {field.intensityScale, field.intensityOffset}, closedForm, plan.smoothAlongNormal)) {
        pool.throwIfStopped();
        observations.push_back(std::move(o));
      }
  const std::int64_t most =
      std::max(checkpoint.field.size(),
               members * std::max(field.size(), plan.densify.every > 0 ? plan.densify.limit : 0));
  FitRequest request = fitRequest(std::move(observations), plan, field, pool.stopToken(), most);
  request.sweeps *= members;
  std::unique_ptr<FitDevice> placed = place(request, result);
  Trainer trainer(std::move(field), std::move(request), plan, kernels, pool, std::move(placed));
  if (complete) {
    result.trainingPsnr = state.trainingPsnr = psnrOf(trainer.evaluate(checkpoint.field));
    noticeFailure(trainer, member * perMember, result);
    return;
  }
  if (same && !resume->moment1.empty())
    trainer.restore(resume->moment1, resume->moment2, resume->iteration % perMember, resume->losses,
                    resume->pulls);
  checkpoint = {};
  checkpoint.field = merged;
  checkpoint.settingsKey = key;
  bool between = false;   // the last member is done, the next one has no Gaussians yet
  const auto keep = [&] { // the state to go on from
    const GaussianField& reached = trainer.field();
    checkpoint.finished = checkpoint.field.size();
    checkpoint.field.cutoff = reached.cutoff;
    checkpoint.iteration = member * perMember + (between ? 0 : trainer.iteration());
    if (!between) {
      const auto& open = reached.gaussians;
      checkpoint.field.gaussians.insert(checkpoint.field.gaussians.end(), open.begin(), open.end());
      checkpoint.moment1 = trainer.adam().moment1;
      checkpoint.moment2 = trainer.adam().moment2;
      checkpoint.losses = trainer.losses();
      checkpoint.pulls = trainer.pulls();
    }
    result.iterations = checkpoint.iteration;
    result.trainingPsnr = state.trainingPsnr;
    if (!between) result.densified += trainer.densified();
  };
  try {
    for (;;) {
      sweep(trainer, prepared.outputGrid, member * perMember, pool, result);
      if (member + 1 >= members) break;
      const auto& done = trainer.field().gaussians;
      checkpoint.field.gaussians.insert(checkpoint.field.gaussians.end(), done.begin(), done.end());
      result.densified += trainer.densified();
      ++member;
      between = true;
      trainer.restart(startField(prepared, member, pool));
      between = false;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) {
      keep();
      noticeFailure(trainer, member * perMember, result);
    }
    throw;
  }
  keep();
  checkpoint.moment1.clear();
  checkpoint.moment2.clear();
  checkpoint.losses.clear();
  checkpoint.pulls.clear();
  checkpoint.finished = checkpoint.field.size();
  if (members > 1) checkpoint.field.gaussians = inMortonOrder(std::move(checkpoint.field.gaussians));
  result.trainingPsnr = state.trainingPsnr = psnrOf(trainer.evaluate(checkpoint.field));
  noticeFailure(trainer, member * perMember, result);
}

/// The fit on the chosen device; null: on the CPU.
std::unique_ptr<FitDevice> ReconstructionJob::Impl::place(const FitRequest& request,
                                                          ReconstructionResult& result) {
  device->weigh(request);
  const bool hoped = !device->onCpu();
  std::unique_ptr<FitDevice> placed = device->makeFit(request);
  if (hoped && !placed) result.warnings.push_back(device->use.reason);
  result.device = device->use;
  reportDevice(state.phase);
  return placed;
}

/// A fit that left its device is the user's to know.
void ReconstructionJob::Impl::noticeFailure(const Trainer& trainer, int before,
                                            ReconstructionResult& result) {
  if (trainer.failure().empty() || device->onCpu()) return;
  const int from = before + trainer.iteration();
  const std::string lost = from <= state.iteration && !trainer.finished()
                               ? " again from sweep " + std::to_string(from)
                               : std::string();
  device->leave(device->use.name + " (" + device->use.id + ") failed after sweep " +
                std::to_string(state.iteration) + ", and the fit went on" + lost + ": " + trainer.failure());
  result.device = device->use;
  result.warnings.push_back(device->use.reason);
  reportDevice(state.phase);
}

void ReconstructionJob::Impl::sweep(Trainer& trainer, const GridGeometry& grid, int before, ThreadPool& pool,
                                    ReconstructionResult& result) {
  int most = 1; // sweeps of a device from one report to the next
  for (;;) {
    const auto asked = Clock::now();
    const int from = trainer.iteration();
    if (!trainer.step(most)) break;
    const int done = trainer.iteration() - from;
    if (done > 0)
      most = std::clamp(static_cast<int>(std::min(kReportEvery * done / std::max(since(asked), 1e-6), 1e6)),
                        1, 2 * done);
    noticeFailure(trainer, before, result);
    if (device->note(trainer.remark())) {
      result.device = device->use;
      reportDevice(state.phase);
    }
    state.gaussians = checkpoint.field.size() + trainer.gaussians();
    state.iteration = before + trainer.iteration();
    state.loss = trainer.loss();
    state.trainingPsnr = psnrOf(trainer.mse());
    const double share = static_cast<double>(state.iteration) / std::max(1, state.iterations);
    report(Phase::Fitting, kFitStarts + (kFitEnds - kFitStarts) * share);
    if (preview && !trainer.finished() && since(start) >= nextPreview) {
      pool.throwIfStopped();
      const auto begun = Clock::now();
      const GaussianField& field = trainer.field();
      preview(render(field, reduced(grid, 96), renderOptions(field, pool.stopToken())));
      nextPreview = since(start) + std::max(2.0, 20 * since(begun));
    }
  }
}

void ReconstructionJob::Impl::addDetail(const PreparedInput& prepared, ThreadPool& pool,
                                        ReconstructionResult& result) {
  GaussianField& field = checkpoint.field;
  if (!settings.consistency || traits.thickness <= 0) return;
  if (std::any_of(prepared.stacks.begin(), prepared.stacks.end(),
                  [](const Stack& s) { return !s.poses.empty(); }))
    return;
  report(Phase::Refining, kFitEnds);
  Volume volume = render(field, field.domain, renderOptions(field, pool.stopToken()));
  const std::vector<float> before = volume.voxels;
  BackProjectionPlan refinement;
  refinement.noise = result.noise;
  refinement.lowest = field.intensityOffset;
  const double rms = backProject(volume, prepared.stacks, refinement, pool);
  for (std::size_t v = 0; v < before.size(); ++v)
    volume.voxels[v] = static_cast<float>((volume.voxels[v] - before[v]) / field.intensityScale);
  if (std::any_of(volume.voxels.begin(), volume.voxels.end(), [](float x) { return x != 0; }))
    field.detail = std::move(volume);
  result.trainingPsnr = state.trainingPsnr =
      psnrOf(rms * rms / (field.intensityScale * field.intensityScale));
}

double ReconstructionJob::Impl::heldOutPsnr(const PreparedInput& prepared, const GaussianField& field,
                                            const RenderOptions& options) const {
  double squared = 0;
  std::int64_t count = 0;
  for (std::size_t s = 0; s < prepared.stacks.size(); ++s) {
    if (prepared.heldOut[s].empty()) continue;
    const Stack& withheld = input.stacks[s];
    const auto& scored = prepared.scored[s];
    const Volume rendered = renderStack(field, withheld, options);
    const std::int64_t plane = withheld.image.geometry.size[0] * withheld.image.geometry.size[1];
    for (std::int64_t k : prepared.heldOut[s])
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
        const float truth = withheld.image.voxels[v];
        if (!std::isfinite(truth) || (!scored.empty() && !scored[v])) continue;
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
  refitting = false;
  checkSettings(settings);
  const KernelSet& kernels = kernelSet(settings.instructionSet, settings.selection);
  device.emplace(settings.device, settings.instructionSet, settings.selection);
  report(Phase::Preparing, 0);
  ReconstructionResult result;
  result.device = device->use;
  result.instructionSet = kernels.name;
  result.heldOutPsnr = kNaN;
  for (const Stack& stack : input.stacks)
    checkStack(stack);
  const std::int64_t needed = estimateMemory(input, settings), available = availableMemory();
  if (available > 0 && needed > available)
    throw Error(ErrorCode::Memory,
                "The reconstruction needs about " + gigabytes(needed) + " of memory and " +
                    gigabytes(available) +
                    " are available: choose a smaller region, a coarser output or fewer Gaussians.");
  PreparedInput prepared;
  try {
    prepared = prepareInput(input, stop);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    result.settings = settings;
    result.trainingPsnr = kNaN;
    // What was given is what was reached; without its volume it counts as nothing.
    result.checkpoint =
        input.resume && !renderWhenCancelled ? input.resume : std::make_shared<const Checkpoint>();
    result.iterations = result.checkpoint->iteration;
    result.seconds = since(start);
    return result;
  }
  result.nonFiniteVoxels = prepared.nonFinite;
  result.warnings = prepared.warnings;
  ThreadPool pool(settings.threads);
  pool.setStop(stop);
  checkpoint = input.resume ? *input.resume : Checkpoint{};
  result.iterations = checkpoint.iteration;
  result.settings = settings;
  result.trainingPsnr = kNaN;
  try {
    choose(prepared, pool, result);
    const auto begun = Clock::now();
    fit(prepared, kernels, pool, result);
    result.fitSeconds = since(begun);
    result.iterations = checkpoint.iteration;
    addDetail(prepared, pool, result);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    result.iterations = checkpoint.iteration;
  }
  const GaussianField& field = checkpoint.field;
  const auto finish = [&](const std::stop_token& token) {
    report(Phase::Rendering, kDetailEnds);
    const RenderOptions options = renderOptions(field, token);
    result.volume = render(field, prepared.outputGrid, options);
    result.heldOutPsnr = heldOutPsnr(prepared, field, options);
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
  result.checkpoint = std::make_shared<const Checkpoint>(std::move(checkpoint));
  result.seconds = since(start);
  rememberSpeed(input, result);
  if (!result.cancelled) report(Phase::Done, 1);
  return result;
}

} // namespace innergs
