#include "Core/Job/ReconstructionRun.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Fit/CoverUnreached.h"
#include "Core/Image/Metrics.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/PredictedScans.h"
#include "Core/Job/Resume.h"
#include "Core/Job/ShareTrial.h"
#include "Core/Job/TimeEstimate.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::atomic<int> running{0};

double psnrOf(const LossSum& sum) {
  return innergs::psnrOf(sum.squared / static_cast<double>(std::max<std::int64_t>(1, sum.samples)));
}

/// At most `count` of the stack's slices, evenly spread.
Stack someSlices(const Stack& stack, std::int64_t count) {
  const GridGeometry& g = stack.image.geometry;
  const std::int64_t step = (g.size[2] + count - 1) / count, first = (g.size[2] - 1) % step / 2;
  const auto plane = static_cast<std::size_t>(g.size[0] * g.size[1]);
  Stack some;
  some.thickness = stack.thickness > 0 ? stack.thickness : g.spacing[2];
  some.profile = stack.profile;
  some.pixelWidth = stack.pixelWidth;
  some.image.geometry = g;
  some.image.geometry.size[2] = 0;
  some.image.geometry.spacing[2] *= static_cast<double>(step);
  some.image.geometry.origin = g.indexToWorld()({0, 0, static_cast<double>(first)});
  for (auto k = static_cast<std::size_t>(first); k < static_cast<std::size_t>(g.size[2]);
       k += static_cast<std::size_t>(step)) {
    ++some.image.geometry.size[2];
    const auto copy = [&](const auto& from, auto& to) {
      if (!from.empty())
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(k * plane),
                  from.begin() + static_cast<std::ptrdiff_t>((k + 1) * plane));
    };
    copy(stack.image.voxels, some.image.voxels);
    copy(stack.observed, some.observed);
    if (!stack.poses.empty()) some.poses.push_back(stack.poses[k]);
  }
  return some;
}

constexpr double kReportEvery = 0.05; // seconds, minimum, while a device iterates
constexpr std::int64_t kCompared = 8; // slices of each scan that are compared with the result

} // namespace

int runningJobs() {
  return running;
}

ReconstructionRun::ReconstructionRun(const ReconstructionInput& input, const Settings& settings, bool heldOut,
                                     ProgressCallback progress, std::function<void(const Volume&)> preview)
    : input_(input), settings_(settings), heldOut_(heldOut), progress_(std::move(progress)),
      preview_(std::move(preview)) {
  ++running;
}

ReconstructionRun::~ReconstructionRun() {
  --running;
}

ReconstructionResult ReconstructionRun::run(const std::stop_token& stop, bool renderWhenCancelled) {
  checkSettings(settings_);
  kernels_ = &kernelSet(settings_.instructionSet, settings_.selection);
  device_.emplace(settings_.device, settings_.instructionSet, settings_.selection);
  progress_.report(Phase::Preparing, 0);
  if (settings_.n4 && !input_.n4)
    throw Error(ErrorCode::InvalidArgument,
                "N4 is not available here: leave the setting n4 out, or give a scan that N4 has corrected.");
  result_.device = device_->use;
  result_.instructionSet = kernels_->name;
  for (const Stack& stack : input_.stacks)
    checkStack(stack);
  if (!heldOut_) // once, before the first fit, for both
    if (const std::string refusal = memoryRefusal(estimateMemory(input_, settings_), availableMemory());
        !refusal.empty())
      throw Error(ErrorCode::Memory, refusal);
  pool_ = std::make_unique<ThreadPool>(settings_.threads);
  result_.threads = pool_->threads();
  pool_->setStop(stop);
  try {
    correction_.emplace(input_, settings_, heldOut_, progress_, *pool_);
    prepared_ = prepareInput(input_, stop, heldOut_,
                             [this](std::span<Stack> stacks) { return correction_->apply(stacks); });
    correction_->report(result_);
    for (std::size_t s = 0; heldOut_ && s < prepared_.scored.size(); ++s)
      correction_->leaveOutNotAcquired(s, prepared_.scored[s]);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result_.cancelled = true;
    result_.settings = settings_;
    result_.trainingPsnr = kNaN;
    // Nothing was added to what was given; without its volume the result is empty.
    result_.model = input_.resume && !renderWhenCancelled ? input_.resume : std::make_shared<const Model>();
    result_.iterations = result_.model->iteration;
    result_.seconds = progress_.elapsed();
    return std::move(result_);
  }
  result_.nonFiniteVoxels = prepared_.nonFinite;
  result_.warnings = prepared_.warnings;
  model_ = input_.resume ? *input_.resume : Model{};
  result_.iterations = model_.iteration;
  result_.settings = settings_;
  result_.trainingPsnr = kNaN;
  std::optional<std::chrono::steady_clock::time_point> begun; // start of the fit, until it has ended
  const auto endFit = [&] {
    result_.iterations = model_.iteration;
    if (begun) result_.fitSeconds = secondsSince(*begun);
    begun.reset();
  };
  try {
    choose();
    begun = std::chrono::steady_clock::now();
    fit();
    endFit();
    addResidual();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result_.cancelled = true;
    endFit();
  }
  if (!result_.cancelled) {
    try {
      renderResult(stop);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Cancelled) throw;
      result_.cancelled = true;
      result_.volume = {};
    }
  }
  if (result_.cancelled && renderWhenCancelled && !model_.field.gaussians.empty()) renderResult({});
  result_.model = std::make_shared<const Model>(std::move(model_));
  result_.seconds = progress_.elapsed();
  const bool goesOn = input_.resume && !refitting_ && !input_.resume->field.gaussians.empty();
  result_.iterationsRun = std::max(0, result_.iterations - (goesOn ? input_.resume->iteration : 0));
  rememberSpeed(input_, result_);
  if (!result_.cancelled) progress_.report(Phase::Done, 1);
  return std::move(result_);
}

void ReconstructionRun::choose() {
  pool_->throwIfStopped();
  map_ = chooseIntensityMap(prepared_.stacks);
  pool_->throwIfStopped();
  traits_ = measureTraits(prepared_.stacks, map_);
  traits_.disagreement = correction_->disagreement();
  if (posesFound_ && traits_.posed) traits_ = withMovedSlices(traits_);
  result_.noise = traits_.noise * map_.scale;
  if (predicts(settings_, traits_)) {
    PredictedScans predicted = predictScans(
        prepared_, settings_, input_.predictionParts, map_,
        [this](const Stack& slices, const GridGeometry& grid, const Settings& settings, double from,
               double to) { return fieldAlone(slices, grid, settings, from, to); },
        progress_, *pool_);
    traits_.volume *= predicted.kept;
    predictionNoise_ = predicted.noise;
    averaged_ = std::move(predicted.averaged);
    result_.prediction = std::move(predicted.sentence);
    predicted_ = std::move(predicted.thin);
  }
  predictsEach_ = !correction_->differentBodies() &&
                  predictsEach(settings_, traits_, prepared_.stacks, !input_.masks.empty());
  asked_ = settings_;
  if (!settings_.gaussians) {
    Settings whole = settings_;
    const InitialisationPlan start = makePlan(whole, traits_).start;
    std::vector<Stack> bridged;
    traits_.reached =
        reachedShare(startedStacks(bridged), map_, start, traits_.volume, traits_.voxel, *pool_);
  }
  plan_ = makePlan(settings_, traits_);
  key_ = settingsKey(settings_, prepared_.fingerprint);
  if (input_.resume && !input_.resume->field.gaussians.empty() && input_.resume->settingsKey != key_) {
    // Refits one field as it is: further members would start in another frame.
    settings_ = asked_;
    settings_.ensembleSize = 1;
    settings_.blending = input_.resume->field.blending;
    settings_.linearIntensity = input_.resume->field.linearIntensity;
    plan_ = makePlan(settings_, traits_);
    key_ = settingsKey(settings_, prepared_.fingerprint);
    refitting_ = true;
  }
  result_.settings = settings_;
}

/// The volume of a one-member field fitted to the slices alone.
Volume ReconstructionRun::fieldAlone(const Stack& stack, const GridGeometry& grid, const Settings& settings,
                                     double from, double to) {
  ReconstructionInput input;
  input.stacks = {stack};
  input.outputGrid = grid;
  Settings prepared = settings;
  prepared.n4 = false;
  // `heldOut` is true as the slices are already prepared.
  ReconstructionRun other(input, prepared, true, [&](const Progress& p) {
    progress_.report(Phase::Predicting, from + (to - from) * p.fraction);
  });
  ReconstructionResult found = other.run(pool_->stopToken(), false);
  if (found.cancelled) throw Error(ErrorCode::Cancelled, "Stopped on request.");
  return std::move(found.volume);
}

/// The stacks that Gaussians are fitted to: the input's, or the prediction from its only one.
std::span<const Stack> ReconstructionRun::fittedStacks() const {
  return predicted_ ? std::span<const Stack>(&*predicted_, 1) : prepared_.stacks;
}

/// The stacks that Gaussians are initialised from.
std::span<const Stack> ReconstructionRun::startedStacks(std::vector<Stack>& bridged) const {
  return predicted_ ? fittedStacks() : startStacks(prepared_, bridged);
}

/// Sets where the field has values, and their range.
void ReconstructionRun::setPlace(GaussianField& field) const {
  field.domain = prepared_.domain;
  field.support = prepared_.support;
  field.fill = static_cast<float>(settings_.fill);
  field.range = prepared_.range;
}

GaussianField ReconstructionRun::startField(int member) {
  GaussianField field;
  field.blending = *settings_.blending;
  field.linearIntensity = plan_.linearIntensity;
  field.modelToWorld = modelFrame(prepared_.stacks.front().image.geometry);
  field.intensityScale = map_.scale;
  field.intensityOffset = map_.offset;
  field.cutoff = plan_.cutoff;
  setPlace(field);
  std::vector<Stack> bridged;
  const ProxyVolume proxy =
      makeProxy(startedStacks(bridged), field.modelToWorld, map_, traits_.voxel, *pool_);
  initialise(field, proxy, plan_.start, settings_.seed + static_cast<std::uint64_t>(member), *pool_);
  if (field.gaussians.empty())
    throw Error(ErrorCode::NoData,
                "No Gaussian could be placed: the images observe no voxel of their own grid.");
  return field;
}

std::vector<Observation> ReconstructionRun::observations(const GaussianField& field) const {
  std::vector<Observation> observations;
  const double resolution = prepared_.domain.finestSpacing();
  const bool closedForm = field.blending == Blending::Additive && !field.linearIntensity;
  int scan = 0;
  for (const Stack& stack : fittedStacks()) {
    const int subset = scan++ % plan_.subsets;
    for (int axis = 2; axis >= (plan_.allAxes ? 0 : 2); --axis)
      for (Observation& o : observe(withSliceAxis(stack, axis), field.modelToWorld,
                                    {field.intensityScale, field.intensityOffset}, closedForm,
                                    plan_.smoothAlongNormal, resolution)) {
        pool_->throwIfStopped();
        o.subset = subset;
        observations.push_back(std::move(o));
      }
  }
  return observations;
}

/// The progress after this share of what begins with the fit.
double ReconstructionRun::fromFit(double share) const {
  return fitStarts_ + (1 - fitStarts_) * share;
}

void ReconstructionRun::fit() {
  const Model* resume = input_.resume.get();
  if (resume && resume->field.gaussians.empty()) resume = nullptr; // stopped before its first Gaussians
  const bool same = resume && !refitting_;
  const int members = *settings_.ensembleSize, perMember = *settings_.iterations;
  progress_.state.iterations = members * perMember;
  progress_.state.members = members;
  progress_.state.coarseIterations = plan_.coarseIterations;
  fitStarts_ = std::max(kFitStarts, progress_.state.fraction); // a search for motion may have ended early
  progress_.changePace();
  int member = same ? resume->iteration / perMember : 0;
  GaussianField field, merged;
  bool complete = false; // only residual grid and volume remain to be computed
  if (resume) {
    checkField(resume->field);
    field = resume->field;
    field.residual = {};
    setPlace(field);
    if (!same)
      result_.warnings.push_back(
          "The model to resume was made with other settings or images: its Gaussians are the start of a new "
          "fit.");
  }
  if (same) {
    checkResumable(*resume, progress_.state.iterations);
    model_ = *resume; // stopped before any work: returns the given model
    setPlace(model_.field);
    model_.field.residual = {};
    complete = resume->complete() && resume->iteration > (members - 1) * perMember;
  }
  if (same && !complete) {
    const auto open = field.gaussians.begin() + resume->finished;
    merged = field;
    merged.gaussians.assign(field.gaussians.begin(), open);
    field.gaussians.erase(field.gaussians.begin(), open);
  }
  if (field.gaussians.empty()) {
    progress_.report(Phase::Initialising, 0.02);
    field = startField(member);
  }
  if (!same) {
    merged = field;
    merged.gaussians.clear();
  }
  std::int64_t most =
      std::max(model_.field.size(),
               members * std::max(field.size(), plan_.densify.every > 0 ? plan_.densify.limit : 0));
  most += coverLimit(most);
  FitRequest request = fitRequest(observations(field), plan_, field, pool_->stopToken(), most);
  request.iterations *= members;
  std::unique_ptr<FitDevice> placed = place(request);
  Trainer trainer(std::move(field), std::move(request), plan_, *kernels_, *pool_, std::move(placed));
  if (complete) {
    coverMask(); // an earlier run may have been stopped just before this
    setTrainingPsnr(psnrOf(trainer.evaluate(model_.field)));
    noticeFailure(trainer, member * perMember);
    return;
  }
  if (same && !resume->complete()) trainer.restore(resume->optimizer, resume->iteration % perMember);
  model_ = {};
  model_.field = merged;
  model_.settingsKey = key_;
  bool between = false;   // the last member is finished, the next has no Gaussians yet
  const auto keep = [&] { // the state to resume from
    const GaussianField& reached = trainer.field();
    model_.finished = model_.field.size();
    model_.field.cutoff = reached.cutoff;
    model_.iteration = member * perMember + (between ? 0 : trainer.iteration());
    if (!between) {
      const auto& open = reached.gaussians;
      model_.field.gaussians.insert(model_.field.gaussians.end(), open.begin(), open.end());
      model_.optimizer = trainer.optimizer();
    }
    result_.iterations = model_.iteration;
    result_.trainingPsnr = progress_.state.trainingPsnr;
    if (!between) result_.densified += trainer.densified();
  };
  try {
    for (;;) {
      iterate(trainer, member * perMember);
      if (member + 1 >= members) break;
      const auto& done = trainer.field().gaussians;
      model_.field.gaussians.insert(model_.field.gaussians.end(), done.begin(), done.end());
      result_.densified += trainer.densified();
      ++member;
      between = true;
      trainer.restart(startField(member));
      between = false;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) {
      keep();
      noticeFailure(trainer, member * perMember);
    }
    throw;
  }
  keep();
  model_.optimizer = {};
  model_.finished = model_.field.size();
  coverMask();
  if (members > 1) model_.field.gaussians = inMortonOrder(std::move(model_.field.gaussians));
  setTrainingPsnr(psnrOf(trainer.evaluate(model_.field)));
  noticeFailure(trainer, member * perMember);
}

/// How many Gaussians coverMask() may add.
std::int64_t ReconstructionRun::coverLimit(std::int64_t gaussians) const {
  return !input_.masks.empty() && settings_.blending == Blending::Normalised ? gaussians / 20 + 16 : 0;
}

/// Covers the voxels that a masked fit left without Gaussians.
void ReconstructionRun::coverMask() {
  GaussianField& field = model_.field;
  const std::int64_t most = coverLimit(field.size());
  if (most > 0 && coverUnreached(field, fittedStacks(), most, renderOptions(field, pool_->stopToken())))
    model_.finished = field.size();
}

/// The fit on the chosen device; null: the CPU.
std::unique_ptr<FitDevice> ReconstructionRun::place(const FitRequest& request) {
  device_->considerSize(request);
  const bool hoped = !device_->onCpu();
  std::unique_ptr<FitDevice> placed = device_->makeFit(request);
  if (hoped && !placed) result_.warnings.push_back(device_->use.reason);
  result_.device = device_->use;
  reportDevice();
  return placed;
}

/// Tells the user that a fit left its device.
void ReconstructionRun::noticeFailure(const Trainer& trainer, int before) {
  if (trainer.failure().empty() || device_->onCpu()) return;
  const int from = before + trainer.iteration();
  const std::string lost = from <= progress_.state.iteration && !trainer.finished()
                               ? " again from iteration " + std::to_string(from)
                               : std::string();
  device_->failed("after iteration " + std::to_string(progress_.state.iteration) + ", and the fit continued" +
                      lost,
                  trainer.failure());
  result_.device = device_->use;
  result_.warnings.push_back(device_->use.reason);
  reportDevice();
}

void ReconstructionRun::iterate(Trainer& trainer, int before) {
  int most = 1; // iterations that a device runs between reports
  for (;;) {
    const auto asked = Clock::now();
    const int from = trainer.iteration();
    if (!trainer.step(most)) break;
    const int done = trainer.iteration() - from;
    if (done > 0)
      most = std::clamp(
          static_cast<int>(std::min(kReportEvery * done / std::max(secondsSince(asked), 1e-6), 1e6)), 1,
          2 * done);
    if (trainer.iteration() == plan_.coarseIterations) most = 1; // what follows takes several times as long
    noticeFailure(trainer, before);
    if (device_->note(trainer.remark())) {
      result_.device = device_->use;
      reportDevice();
    }
    progress_.state.gaussians = model_.field.size() + trainer.gaussians();
    progress_.state.iteration = before + trainer.iteration();
    progress_.state.loss = trainer.loss();
    progress_.state.trainingPsnr = psnrOf(trainer.mse());
    const double share =
        static_cast<double>(progress_.state.iteration) / std::max(1, progress_.state.iterations);
    progress_.report(Phase::Fitting, fromFit((predictsEach_ ? kEachFitEnds : kFitEnds) * share));
    if (preview_ && !trainer.finished() && progress_.elapsed() >= nextPreview_) {
      pool_->throwIfStopped();
      const auto begun = Clock::now();
      const GaussianField& field = trainer.field();
      preview_(render(field, reduced(prepared_.outputGrid, 96), renderOptions(field, pool_->stopToken())));
      nextPreview_ = progress_.elapsed() + std::max(2.0, 20 * secondsSince(begun));
    }
  }
}

void ReconstructionRun::addResidual() {
  GaussianField& field = model_.field;
  DataTraits traits = traits_;
  traits.posed = !posesFound_ && std::any_of(input_.stacks.begin(), input_.stacks.end(),
                                             [](const Stack& s) { return !s.poses.empty(); });
  if (!predicted_ && !addsResidual(settings_, traits)) return;
  progress_.report(Phase::Refining, fromFit(predictsEach_ ? kEachFitEnds : kFitEnds));
  const RenderOptions options = renderOptions(field, pool_->stopToken());
  if (predictsEach_ && share_.value_or(0) > 0 && !keepsUnmixed_)
    return mixPredictions(options); // refines with them
  double mse;
  if (predicted_)
    mse = refineToPrediction(field, *predicted_, averaged_, prepared_.stacks, predictionNoise_, options,
                             *pool_);
  else if (traits_.thickness > 0)
    mse = refineToSlices(field, prepared_.stacks, result_.noise, prepared_.range, options, *pool_);
  else
    mse = refineToThinScans(field, prepared_.stacks, result_.noise, options, *pool_);
  setTrainingPsnr(psnrOf(mse));
  if (predictsEach_) mixPredictions(options);
}

/// Mixes what each scan predicts alone into the refined field, which stays as it is where that does not help.
void ReconstructionRun::mixPredictions(const RenderOptions& options) {
  if (keepsUnmixed_) unmixed_ = render(model_.field, prepared_.outputGrid, options);
  const std::optional<double> chosen = share_ ? share_ : chooseShare(options);
  result_.predictionShare = chosen.value_or(0);
  result_.prediction =
      result_.predictionShare > 0
          ? formatted(
                "Between the slices, predictions from each scan alone count for %.0f %%, as a simulation "
                "of these scans suggests.",
                100 * result_.predictionShare)
          : std::string("Predictions from each scan alone were left out: ") +
                (chosen ? "in a simulation of these scans they did not help."
                        : "the scans are too small to try them in a simulation.");
  if (result_.predictionShare > 0) {
    std::vector<Stack> predictions = predictEach();
    progress_.report(Phase::Refining, fromFit(kFitEnds));
    GaussianField mixed = model_.field;
    mixed.residual = {};
    const double mse = refineToSlices(mixed, prepared_.stacks, result_.noise, prepared_.range, options,
                                      *pool_, predictions, result_.predictionShare);
    model_.field = std::move(mixed);
    setTrainingPsnr(psnrOf(mse));
  }
  progress_.state.note = result_.prediction;
  progress_.report(Phase::Predicting, fromFit(kFitEnds));
  progress_.state.note.clear();
}

/// The share of the predictions from each scan, by a trial; nothing where the scans are too small for it.
std::optional<double> ReconstructionRun::chooseShare(const RenderOptions& options) {
  Settings settings = asked_;
  settings.iterations = settings_.iterations;
  ShareTrial trial = shareTrial([&](const GridGeometry& grid) { return render(model_.field, grid, options); },
                                prepared_.stacks, prepared_.domain, settings, result_.noise, *pool_);
  if (trial.refit.input.stacks.empty()) return std::nullopt;
  trial.refit.input.predictionParts = input_.predictionParts;
  ReconstructionRun refit(trial.refit.input, trial.refit.settings, true, [&](const Progress& p) {
    progress_.report(Phase::Predicting, fromFit(kEachFitEnds + (kShareChosen - kEachFitEnds) * p.fraction));
  });
  refit.setPredictionShare(kTriedShare);
  refit.keepUnmixed();
  const ReconstructionResult mixed = refit.run(pool_->stopToken(), false);
  if (mixed.cancelled) throw Error(ErrorCode::Cancelled, "Stopped on request.");
  return chosenShare(trial.truth, refit.takeUnmixed(), mixed.volume, traits_.noise);
}

/// What each scan shows between its own slices, as thin slices.
std::vector<Stack> ReconstructionRun::predictEach() {
  std::vector<Stack> predictions;
  const double width = (kFitEnds - kShareChosen) / static_cast<double>(prepared_.stacks.size());
  for (const Stack& stack : prepared_.stacks) {
    const double from = kShareChosen + width * static_cast<double>(predictions.size());
    PredictedPart part = predictPart(
        prepared_, stack, prepared_.domain, scanSettings(settings_), input_.predictionParts,
        {result_.noise, false},
        [this](const Stack& slices, const GridGeometry& grid, const Settings& alone, double begins,
               double ends) { return fieldAlone(slices, grid, alone, begins, ends); },
        {fromFit(from), fromFit(from + width)}, progress_, *pool_);
    predictions.push_back(std::move(part.thin));
  }
  return predictions;
}

void ReconstructionRun::scoreHeldOut(const RenderOptions& options) {
  const GaussianField& field = model_.field;
  double squared = 0;
  std::int64_t count = 0;
  int slice = -1;
  for (std::size_t s = 0; s < prepared_.stacks.size(); ++s) {
    if (prepared_.heldOut[s].empty()) continue;
    const Stack whole = correction_->placed(
        s, prepared_.heldOut[s], [&](const GridGeometry& grid) { return render(field, grid, options); },
        prepared_.range.low >= 0);
    const Affine3 map = whole.image.geometry.indexToWorld();
    const auto& scored = prepared_.scored[s];
    const Volume rendered = renderStack(field, whole, options);
    const std::int64_t row = whole.image.geometry.size[0], plane = row * whole.image.geometry.size[1];
    for (std::int64_t k : prepared_.heldOut[s]) {
      const std::int64_t before = count;
      const Affine3 pose = whole.poses.empty() ? Affine3{} : whole.poses[static_cast<std::size_t>(k)];
      ++slice;
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
        const float truth = whole.image.voxels[v];
        if (!std::isfinite(truth) || (!scored.empty() && !scored[v])) continue;
        const double e = (rendered.voxels[v] - truth) / field.intensityScale;
        squared += e * e;
        ++count;
        if (!keepsValues_) continue;
        const std::int64_t p = v - k * plane;
        heldOutValues_.push_back(
            {pose(map({static_cast<double>(p % row), static_cast<double>(p / row), static_cast<double>(k)})),
             rendered.voxels[v] - truth, slice});
      }
      result_.heldOutSlices += count > before;
    }
  }
  if (count > 0) result_.heldOutPsnr = psnrOf(squared / static_cast<double>(count));
  progress_.state.heldOutPsnr = result_.heldOutPsnr;
}

void ReconstructionRun::renderResult(const std::stop_token& stop) {
  progress_.report(Phase::Rendering, fromFit(kResidualEnds));
  const RenderOptions options = renderOptions(model_.field, stop);
  result_.volume = render(model_.field, prepared_.outputGrid, options);
  if (heldOut_)
    scoreHeldOut(options);
  else
    compareWithScans(options);
}

/// Measures how well the result shows some of the slices of each of several scans.
void ReconstructionRun::compareWithScans(const RenderOptions& options) {
  const auto& stacks = prepared_.stacks;
  if (result_.agreement.size() != stacks.size()) return;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    const Stack some = someSlices(stacks[s], kCompared);
    const Volume seen = renderStack(model_.field, some, options);
    LossSum sum;
    for (std::size_t v = 0; v < seen.voxels.size(); ++v) {
      const double e = (seen.voxels[v] - some.image.voxels[v]) / model_.field.intensityScale;
      if ((!some.observed.empty() && !some.observed[v]) || !std::isfinite(e)) continue;
      sum.squared += e * e;
      ++sum.samples;
    }
    if (sum.samples > 0) result_.agreement[s].fittedPsnr = psnrOf(sum);
  }
}

RenderOptions ReconstructionRun::renderOptions(const GaussianField& field, std::stop_token stop) {
  RenderOptions options;
  options.threads = settings_.threads;
  options.instructionSet = settings_.instructionSet;
  options.selection = settings_.selection;
  options.device = device_->makeField(field, stop);
  options.stop = std::move(stop);
  return options;
}

void ReconstructionRun::reportDevice() {
  progress_.say(device_->use.reason);
}

} // namespace innergs
