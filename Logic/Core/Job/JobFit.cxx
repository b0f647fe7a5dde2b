#include "Core/Base/Error.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Job/JobSteps.h"
#include "Core/Job/Resume.h"

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kReportEvery = 0.05; // seconds, at least, while a device iterates

double psnrOf(const LossSum& sum) {
  return innergs::psnrOf(sum.squared / static_cast<double>(std::max<std::int64_t>(1, sum.samples)));
}

/// The lattice reduced so that no axis has more than `most` voxels.
GridGeometry reduced(const GridGeometry& g, std::int64_t most) {
  Vec3 spacing = g.spacing;
  for (int a = 0; a < 3; ++a)
    spacing[a] *= std::max(1.0, static_cast<double>(g.size[a]) / static_cast<double>(most));
  return withSpacing(g, spacing);
}

} // namespace

void ReconstructionJob::Impl::choose(const PreparedInput& prepared, ThreadPool& pool,
                                     ReconstructionResult& result) {
  pool.throwIfStopped();
  map = chooseIntensityMap(prepared.stacks);
  pool.throwIfStopped();
  traits = measureTraits(prepared.stacks, map);
  predict(prepared, pool, result);
  const Settings asked = settings;
  if (!settings.gaussians) {
    Settings whole = settings;
    const InitialisationPlan start = makePlan(whole, traits).start;
    std::vector<Stack> bridged;
    traits.reached =
        reachedShare(startedStacks(prepared, bridged), map, start, traits.volume, traits.voxel, pool);
  }
  plan = makePlan(settings, traits);
  key = settingsKey(settings, prepared.fingerprint);
  if (refits()) { // one field to refit, as it is: further members would start in another frame
    settings = asked;
    settings.ensembleSize = 1;
    settings.blending = input.resume->field.blending;
    settings.linearIntensity = input.resume->field.linearIntensity;
    plan = makePlan(settings, traits);
    key = settingsKey(settings, prepared.fingerprint);
    refitting = true;
  }
  result.noise = traits.noise * map.scale;
  result.settings = settings;
}

/// Where the field has values, and which.
void ReconstructionJob::Impl::setPlace(GaussianField& field, const PreparedInput& prepared) const {
  field.domain = prepared.domain;
  field.support = prepared.support;
  field.fill = static_cast<float>(settings.fill);
  field.range = prepared.range;
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
  setPlace(field, prepared);
  std::vector<Stack> bridged;
  const ProxyVolume proxy =
      makeProxy(startedStacks(prepared, bridged), field.modelToWorld, map, traits.voxel, pool);
  initialise(field, proxy, plan.start, settings.seed + static_cast<std::uint64_t>(member), pool);
  if (field.gaussians.empty())
    throw Error(ErrorCode::NoData,
                "No Gaussian could be placed: the images observe no voxel of their own grid.");
  return field;
}

void ReconstructionJob::Impl::fit(const PreparedInput& prepared, const KernelSet& kernels, ThreadPool& pool,
                                  ReconstructionResult& result) {
  const Model* resume = input.resume.get();
  if (resume && resume->field.gaussians.empty()) resume = nullptr; // stopped before its first Gaussians
  const bool same = resume && !refitting;
  const int members = *settings.ensembleSize, perMember = *settings.iterations;
  state.iterations = members * perMember;
  state.members = members;
  state.coarseIterations = plan.coarseIterations;
  int member = same ? resume->iteration / perMember : 0;
  GaussianField field, merged;
  bool complete = false; // only detail and volume are to be made again
  if (resume) {
    checkField(resume->field);
    field = resume->field;
    field.residual = {};
    setPlace(field, prepared);
    if (!same)
      result.warnings.push_back("The model to resume was made with other settings or images: its Gaussians "
                                "are the start of a new fit.");
  }
  if (same) {
    checkResumable(*resume, state.iterations);
    model = *resume; // stopped before anything is done: what was given
    setPlace(model.field, prepared);
    model.field.residual = {};
    complete = resume->complete() && resume->iteration > (members - 1) * perMember;
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
  for (const Stack& stack : fittedStacks(prepared))
    for (int axis = 2; axis >= (plan.allAxes ? 0 : 2); --axis)
      for (Observation& o :
           observe(withSliceAxis(stack, axis), field.modelToWorld,
                   {field.intensityScale, field.intensityOffset}, closedForm, plan.smoothAlongNormal)) {
        pool.throwIfStopped();
        observations.push_back(std::move(o));
      }
  std::int64_t most = std::max(
      model.field.size(), members * std::max(field.size(), plan.densify.every > 0 ? plan.densify.limit : 0));
  most += coverLimit(most);
  FitRequest request = fitRequest(std::move(observations), plan, field, pool.stopToken(), most);
  request.iterations *= members;
  std::unique_ptr<FitDevice> placed = place(request, result);
  Trainer trainer(std::move(field), std::move(request), plan, kernels, pool, std::move(placed));
  if (complete) {
    coverMask(prepared, pool); // the run before may have been stopped there
    result.trainingPsnr = state.trainingPsnr = psnrOf(trainer.evaluate(model.field));
    noticeFailure(trainer, member * perMember, result);
    return;
  }
  if (same && !resume->complete()) trainer.restore(resume->optimizer, resume->iteration % perMember);
  model = {};
  model.field = merged;
  model.settingsKey = key;
  bool between = false;   // the last member is done, the next one has no Gaussians yet
  const auto keep = [&] { // the state to go on from
    const GaussianField& reached = trainer.field();
    model.finished = model.field.size();
    model.field.cutoff = reached.cutoff;
    model.iteration = member * perMember + (between ? 0 : trainer.iteration());
    if (!between) {
      const auto& open = reached.gaussians;
      model.field.gaussians.insert(model.field.gaussians.end(), open.begin(), open.end());
      model.optimizer = trainer.optimizer();
    }
    result.iterations = model.iteration;
    result.trainingPsnr = state.trainingPsnr;
    if (!between) result.densified += trainer.densified();
  };
  try {
    for (;;) {
      iterate(trainer, prepared.outputGrid, member * perMember, pool, result);
      if (member + 1 >= members) break;
      const auto& done = trainer.field().gaussians;
      model.field.gaussians.insert(model.field.gaussians.end(), done.begin(), done.end());
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
  model.optimizer = {};
  model.finished = model.field.size();
  coverMask(prepared, pool);
  if (members > 1) model.field.gaussians = inMortonOrder(std::move(model.field.gaussians));
  result.trainingPsnr = state.trainingPsnr = psnrOf(trainer.evaluate(model.field));
  noticeFailure(trainer, member * perMember, result);
}

/// How many Gaussians coverMask() may add to so many.
std::int64_t ReconstructionJob::Impl::coverLimit(std::int64_t gaussians) const {
  return input.mask && settings.blending == Blending::Normalised ? gaussians / 20 + 16 : 0;
}

/// A voxel at a mask's ragged edge may have lost every Gaussian that reached it, and with it any gradient
/// that would bring one back: it gets one of its own, too small to reach its neighbours.
void ReconstructionJob::Impl::coverMask(const PreparedInput& prepared, ThreadPool& pool) {
  GaussianField& field = model.field;
  const std::size_t limit = field.gaussians.size() + coverLimit(field.size());
  if (limit == field.gaussians.size()) return;
  const std::vector<float> ones(field.gaussians.size(), 1.f);
  RenderOptions options = renderOptions(field, pool.stopToken());
  options.bounded = false;
  options.values = ones;
  std::vector<Gaussian> added;
  for (const Stack& stack : fittedStacks(prepared)) {
    if (!stack.poses.empty()) continue;
    const GridGeometry& g = stack.image.geometry;
    std::array<std::int64_t, 3> first = g.size, size{0, 0, 0}; // of the block that holds what is observed
    for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
      if (!stack.observed[v]) continue;
      const std::int64_t at[3] = {v % g.size[0], v / g.size[0] % g.size[1], v / (g.size[0] * g.size[1])};
      for (int a = 0; a < 3; ++a) {
        first[a] = std::min(first[a], at[a]);
        size[a] = std::max(size[a], at[a] + 1);
      }
    }
    if (size[0] == 0) continue;
    for (int a = 0; a < 3; ++a)
      size[a] -= first[a];
    const GridGeometry block = cropped(g, first, size);
    const Volume reached = render(field, block, options); // W / (W + ε): 0 where no Gaussian reaches
    const Affine3 toModel = inverse(field.modelToWorld) * block.indexToWorld();
    const double spacing = *std::min_element(g.spacing.begin(), g.spacing.end());
    for (std::int64_t n = 0; n < block.voxelCount(); ++n) {
      if (reached.voxels[n] > 0.5f) continue;
      const std::int64_t i = n % size[0], j = n / size[0] % size[1], k = n / (size[0] * size[1]);
      const std::int64_t v = first[0] + i + g.size[0] * (first[1] + j + g.size[1] * (first[2] + k));
      const float value = stack.image.voxels[v];
      if (!stack.observed[v] || !std::isfinite(value)) continue;
      if (ones.size() + added.size() >= limit) break;
      const Vec3 at = toModel({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      Gaussian gaussian{};
      for (int a = 0; a < 3; ++a) {
        gaussian.mean[a] = static_cast<float>(at[a]);
        gaussian.logScale[a] = static_cast<float>(std::log(0.95 * spacing / field.cutoff));
      }
      gaussian.quaternion[0] = 1;
      gaussian.intensity = static_cast<float>((value - field.intensityOffset) / field.intensityScale);
      added.push_back(gaussian);
    }
  }
  if (added.empty()) return;
  field.gaussians.insert(field.gaussians.end(), added.begin(), added.end());
  field.gaussians = inMortonOrder(std::move(field.gaussians));
  model.finished = field.size();
}

/// The fit on the chosen device; null: on the CPU.
std::unique_ptr<FitDevice> ReconstructionJob::Impl::place(const FitRequest& request,
                                                          ReconstructionResult& result) {
  device->considerSize(request);
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
                               ? " again from iteration " + std::to_string(from)
                               : std::string();
  device->leave(device->use.name + " (" + device->use.id + ") failed after iteration " +
                std::to_string(state.iteration) + ", and the fit went on" + lost + ": " + trainer.failure());
  result.device = device->use;
  result.warnings.push_back(device->use.reason);
  reportDevice(state.phase);
}

void ReconstructionJob::Impl::iterate(Trainer& trainer, const GridGeometry& grid, int before,
                                      ThreadPool& pool, ReconstructionResult& result) {
  int most = 1; // iterations of a device from one report to the next
  for (;;) {
    const auto asked = Clock::now();
    const int from = trainer.iteration();
    if (!trainer.step(most)) break;
    const int done = trainer.iteration() - from;
    if (done > 0)
      most = std::clamp(
          static_cast<int>(std::min(kReportEvery * done / std::max(secondsSince(asked), 1e-6), 1e6)), 1,
          2 * done);
    if (trainer.iteration() == plan.coarseIterations) most = 1; // what follows takes several times as long
    noticeFailure(trainer, before, result);
    if (device->note(trainer.remark())) {
      result.device = device->use;
      reportDevice(state.phase);
    }
    state.gaussians = model.field.size() + trainer.gaussians();
    state.iteration = before + trainer.iteration();
    state.loss = trainer.loss();
    state.trainingPsnr = psnrOf(trainer.mse());
    const double starts = predicted ? kPredictionEnds : kFitStarts;
    const double share = static_cast<double>(state.iteration) / std::max(1, state.iterations);
    report(Phase::Fitting, starts + (kFitEnds - starts) * share);
    if (preview && !trainer.finished() && secondsSince(start) >= nextPreview) {
      pool.throwIfStopped();
      const auto begun = Clock::now();
      const GaussianField& field = trainer.field();
      preview(render(field, reduced(grid, 96), renderOptions(field, pool.stopToken())));
      nextPreview = secondsSince(start) + std::max(2.0, 20 * secondsSince(begun));
    }
  }
}

} // namespace innergs
