#include "Core/Job/SlicePrediction.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Fit/Plan.h"
#include "Core/Prediction/CandidateGrid.h"
#include "Core/Prediction/MissingSlices.h"
#include "Core/Prediction/PredictionShares.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

constexpr double kUsualFall = 1.1; // of linear interpolation relative to the mixture, in a sharp scan
constexpr double kLittle = 0.98;   // a network's error relative to its filter's; above: little to learn
constexpr double kMuch = 0.94;     // below: much to learn, and training takes longer
constexpr double kMost = 0.93;     // below: training takes longest
constexpr double kThick = 0.02;    // by how much both are lower for thick slices
constexpr double kDistant = 3.5;   // slice distance in pixels above which kLittle counts
constexpr int kFewestForTrial = 6; // for a choice on every second one
constexpr double kAsGood = 1.01;   // squared error of fused planes relative to their mean

/// Keeps every second slice.
Stack everySecond(const Stack& stack) {
  Stack half = stack;
  GridGeometry& g = half.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  half.thickness = effectiveThickness(stack);
  half.image.voxels.clear();
  half.observed.clear();
  half.times.clear();
  for (std::int64_t k = 0; k < g.size[2]; k += 2) {
    half.image.voxels.insert(half.image.voxels.end(), stack.image.voxels.begin() + k * plane,
                             stack.image.voxels.begin() + (k + 1) * plane);
    if (!stack.observed.empty())
      half.observed.insert(half.observed.end(), stack.observed.begin() + k * plane,
                           stack.observed.begin() + (k + 1) * plane);
  }
  g = trialGrids(g).kept;
  return half;
}

/// "55 % linear and 45 % cubic interpolation, 20 % a field fitted to the slices".
std::string mixtureText(const CandidateChoice& choice, double field, double learned) {
  std::string text;
  const auto add = [&text](double share, const std::string& what) {
    if (share > 0.005) text += (text.empty() ? "" : ", ") + formatted("%.0f %% ", 100 * share) + what;
  };
  for (int c = 0; c < kCandidates; ++c)
    add((1 - field - learned) * choice.share[c],
        candidateName(static_cast<Candidate>(c)) + std::string(" interpolation"));
  add(field, "a field fitted to the slices");
  add(learned, "learned from the slices' own detail");
  return text;
}

} // namespace

SlicePrediction::SlicePrediction(const PreparedInput& prepared, Settings settings, PredictionParts parts,
                                 double noise, FieldFit fitField, bool thenFitted, JobProgress& progress,
                                 ThreadPool& pool)
    : prepared_(prepared), scan_(prepared.stacks.front()), settings_(std::move(settings)), parts_(parts),
      noise_(noise), fitField_(std::move(fitField)), progress_(progress), pool_(pool),
      cost_(predictionCost(scan_, candidateGrid(scan_.image.geometry, prepared.outputGrid), settings_)) {
  if (!thenFitted) cost_.fit = 0;
}

SlicePrediction::Part SlicePrediction::step(double expected, double cost) {
  Part part{progressed_, progressed_};
  if (cost > 0) part.to += (1 - progressed_) * cost / (costLeft_ + cost - expected);
  progressed_ = part.to;
  costLeft_ -= expected;
  return part;
}

void SlicePrediction::report(double fraction) {
  progress_.report(Phase::Predicting, fraction);
  pool_.throwIfStopped();
}

/// Interpolates between a stack's complete slices with the chosen mixture.
void SlicePrediction::interpolate(const Stack& stack, std::span<const float> complete,
                                  const GridGeometry& grid, std::span<float> planes) const {
  const GridGeometry& g = stack.image.geometry;
  applyWeights(combinedWeights(choice_.share, krigingOf(stack, choice_.krigingBlur), g.size[2],
                               planePositions(g, grid)),
               complete, g.size[0] * g.size[1], planes, pool_);
}

/// guess += M (slices − guess seen as slices), with the mixture's interpolation M: interpolates what a guess
/// misses of the slices.
void SlicePrediction::anchor(Volume& guess, const Stack& scan) const {
  Stack rest = scan;
  const std::vector<float> seen = projectToStack(guess, scan, pool_);
  for (std::size_t v = 0; v < seen.size(); ++v)
    rest.image.voxels[v] -= seen[v]; // NaN where it is not seen
  std::vector<float> correction(guess.voxels.size());
  interpolate(scan, completeSlices(rest, pool_), guess.geometry, correction);
  for (std::size_t v = 0; v < correction.size(); ++v)
    guess.voxels[v] += correction[v];
}

/// Candidates besides interpolation on a grid between a scan's slices, anchored to them: a field fitted to
/// the slices alone, and what is learned across them.
SlicePrediction::Candidates SlicePrediction::makeCandidates(const Stack& scan, const GridGeometry& grid,
                                                            bool withField, bool withLearned, bool trial,
                                                            Part fieldPart, Part learnedPart) {
  Candidates found;
  if (withField) {
    const bool longer = littleToLearn_ && !keepsField_; // would fit noise
    found.field = fitField_(scan, grid,
                            trial ? trialFieldSettings(settings_, voxels_, keepsField_)
                                  : fieldSettings(settings_, longer, keepsField_),
                            fieldPart.from, fieldPart.to);
    if (keepsField_ && !trial) field_ = found.field;
    anchor(*found.field, scan);
  }
  if (withLearned) {
    PredictionOptions options;
    options.effort = learningEffort(settings_, voxels_, trial);
    options.grid = grid;
    options.matchingBlur = choice_.blur;
    options.everySecond = trial;
    options.muchToLearn = muchToLearn_;
    options.fused = fused_;
    options.fromScratch = !parts_.startWeights;
    options.seed = settings_.seed;
    options.instructionSet = settings_.instructionSet;
    Prediction prediction = predictAcrossSlices(scan, options, pool_, [&](const PredictionProgress& p) {
      progress_.report(Phase::Predicting,
                       learnedPart.from + (learnedPart.to - learnedPart.from) * p.fraction);
    });
    found.sentence = prediction.sentence;
    found.pairs = prediction.pairs;
    if (prediction.learned) {
      found.learned = std::move(prediction.image);
      found.known = std::move(prediction.predicted);
      anchor(*found.learned, scan);
      if (trial && fused_) {
        found.mean = std::move(prediction.mean);
        anchor(*found.mean, scan);
      }
    }
  }
  return found;
}

/// The scan with its missing voxels (interpolated in `filled`) filled in: otherwise nothing could be learned
/// across them, nor near them. Mixes their interpolation with what every second slice predicts of the rest
/// (guesses: the mixture, a field if any, what is learned, as slices), as far as that helps at probeSlices().
Stack SlicePrediction::withoutGaps(Stack filled, const std::array<std::span<const float>, 3>& guesses) {
  constexpr int kGuesses = 4;
  const std::int64_t plane = scan_.image.geometry.size[0] * scan_.image.geometry.size[1];
  Stack hidden = scan_;
  const std::vector<std::int64_t> probes = probeSlices(scan_);
  hidden.observed.resize(hidden.image.voxels.size(), 1);
  for (const std::int64_t k : probes)
    std::fill_n(hidden.observed.begin() + k * plane, plane, std::uint8_t{0});
  const std::vector<float> interpolated = completeSlices(hidden, pool_);
  Covariance<kGuesses> errors{};
  for (const std::int64_t k : probes)
    for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
      if (!choice_.inside[v] || !isKnown(scan_, v - plane) || !isKnown(scan_, v + plane)) continue;
      const double truth = scan_.image.voxels[v];
      double e[kGuesses] = {interpolated[v] - truth};
      for (int n = 1; n < kGuesses; ++n)
        e[n] = guesses[n - 1].empty() ? 0 : guesses[n - 1][v] - truth;
      for (int a = 0; a < kGuesses; ++a)
        for (int b = 0; b < kGuesses; ++b)
          errors[a][b] += e[a] * e[b];
    }
  const double none = 1e6 * errors[0][0];
  const auto fill = [&](int parity, const std::array<std::span<const float>, 3>& by, std::int64_t first) {
    Covariance<kGuesses> known = errors;
    for (int n = 1; n < kGuesses; ++n)
      if (by[n - 1].empty()) known[n][n] = none;
    const std::array<double, kGuesses> share = convexShares<kGuesses>(known);
    for (const std::size_t v : missing_[parity]) {
      const std::size_t at = v - static_cast<std::size_t>(first * plane);
      double value = share[0] * filled.image.voxels[v];
      for (int n = 1; n < kGuesses; ++n)
        if (share[n] > 0)
          value += share[n] * (at < by[n - 1].size() ? by[n - 1][at] : filled.image.voxels[v]);
      if (std::isfinite(value)) filled.image.voxels[v] = static_cast<float>(value);
    }
  };
  const bool even = !missing_[0].empty();
  const Part part = step(filling_, even ? filling_ : 0);
  if (!(errors[0][0] > 0)) return filled;
  Stack half;
  GridGeometry middle;
  if (even) { // predicted from odd slices as they were interpolated, as the odd ones were from even ones
    const Stack rest = fromSlice(filled, 1);
    half = everySecond(rest);
    middle = trialGrids(rest.image.geometry).all;
  }
  fill(1, guesses, 0);
  if (!even) return filled;
  const Candidates found = makeCandidates(half, middle, false, true, true, {}, part);
  Volume mixture{middle, std::vector<float>(static_cast<std::size_t>(middle.voxelCount()))};
  interpolate(half, completeSlices(half, pool_), middle, mixture.voxels);
  Stack slices = scan_;
  slices.image = {middle, std::vector<float>(mixture.voxels.size(), 0.f)};
  slices.observed.clear();
  const std::vector<float> mixed = projectToStack(mixture, slices, pool_);
  std::vector<float> learned;
  if (found.learned)
    learned = projectToStack(fused_ || !found.mean ? *found.learned : *found.mean, slices, pool_);
  fill(0, {mixed, {}, learned}, 1);
  return filled;
}

/// Mixes a field fitted to the slices and what can be learned across them into the interpolation, each as far
/// as it helps when every second slice of the scan is held out.
SlicePrediction::Contribution SlicePrediction::addCandidates(Volume& between) {
  const GridGeometry& g = scan_.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  const bool gaps = !missing_[0].empty() || !missing_[1].empty();
  Stack filled;
  if (gaps) filled = withInterpolated(scan_, missing_, pool_);
  const Stack even = everySecond(gaps ? filled : scan_);
  const GridGeometry middle = trialGrids(g).all; // every second plane belongs to a held-out slice
  const Part fieldPart = step(cost_.trialField, cost_.trialField), trialPart = step(cost_.trial, cost_.trial);
  const Candidates tried =
      makeCandidates(even, middle, triesAField(), parts_.learned, true, fieldPart, trialPart);
  Volume mixture{middle, std::vector<float>(static_cast<std::size_t>(middle.voxelCount()))};
  interpolate(even, completeSlices(even, pool_), middle, mixture.voxels);
  constexpr int kept = 3; // guesses that can take part
  const Volume* guesses[kept + 1] = {&mixture, tried.field ? &*tried.field : nullptr,
                                     tried.learned ? &*tried.learned : nullptr,
                                     tried.mean ? &*tried.mean : nullptr};
  // Held-out thick slices are compared with equally thick ones.
  std::array<std::vector<float>, kept + 1> seen;
  Stack all = scan_;
  all.image.geometry = middle;
  all.image.voxels.assign(static_cast<std::size_t>(middle.voxelCount()), 0.f);
  all.observed.clear();
  for (int n = 0; n <= kept; ++n)
    if (guesses[n]) seen[n] = projectToStack(*guesses[n], all, pool_);
  Covariance<kept + 1> measured{};
  for (std::int64_t k = 1; k < middle.size[2]; k += 2)
    for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
      if (!choice_.inside[v]) continue;
      const float truth = scan_.image.voxels[v];
      double e[kept + 1];
      for (int n = 0; n <= kept; ++n)
        e[n] = guesses[n] ? static_cast<double>(seen[n][v]) - truth : 0;
      for (int a = 0; a <= kept; ++a)
        for (int b = 0; b <= kept; ++b)
          measured[a][b] += e[a] * e[b];
    }
  fused_ = !guesses[kept] || measured[kept - 1][kept - 1] <= kAsGood * measured[kept][kept];
  const std::array<int, kept> part{0, 1, fused_ ? kept - 1 : kept};
  Covariance<kept> errors{};
  for (int a = 0; a < kept; ++a)
    for (int b = 0; b < kept; ++b)
      errors[a][b] = measured[part[a]][part[b]];
  const std::array<bool, kept> exists{true, guesses[1] != nullptr, guesses[2] != nullptr};
  // In smooth scans, interpolation's error falls faster with the distance than that of the others.
  const double rise = std::max(1.0, std::sqrt(choice_.linearFall / choice_.fall) / kUsualFall);
  std::array<double, kept> share = predictionShares(errors, exists, {1, rise, rise});
  const auto& spacing = scan_.image.geometry.spacing;
  if (tried.learned && tried.pairs.filter > 0)
    muchToLearn_ =
        std::clamp((kMuch - kThick * relativeThickness(scan_) - tried.pairs.network / tried.pairs.filter) /
                       (kMuch - kMost),
                   0.0, 1.0);
  littleToLearn_ = tried.learned && spacing[2] > kDistant * std::min(spacing[0], spacing[1]) &&
                   tried.pairs.network > kLittle * tried.pairs.filter;
  const bool fits = keepsField_ || share[1] > 0, learns = share[2] > 0;
  if (learns && gaps) {
    filled = withoutGaps(std::move(filled), {seen[0], seen[1], seen[part[2]]});
    interpolate(filled, completeSlices(filled, pool_), between.geometry, between.voxels);
  } else {
    step(filling_, 0);
  }
  choice_.inside = {}; // memory
  const double learning = learns
                              ? learningCost(g, between.geometry, learningEffort(settings_, voxels_, false),
                                             settings_, muchToLearn_)
                              : 0;
  const Candidates learned = makeCandidates(learns && gaps ? filled : scan_, between.geometry, false, learns,
                                            false, {}, step(cost_.learning, learning));
  if (learned.learned)
    share = predictionShares(errors, exists, {1, rise, rise * learnedRise(tried.pairs, learned.pairs)});
  else
    share = {1 - share[1], share[1], 0};
  const Candidates fitted = makeCandidates(scan_, between.geometry, fits, false, false,
                                           step(cost_.field, fits ? cost_.field : 0), {});
  const auto fieldShare = static_cast<float>(share[1]), learnedShare = static_cast<float>(share[2]);
  for (std::size_t v = 0; v < between.voxels.size(); ++v) {
    const float interpolated = between.voxels[v];
    if (fitted.field) between.voxels[v] += fieldShare * (fitted.field->voxels[v] - interpolated);
    if (learned.learned && (learned.known.empty() || learned.known[v]))
      between.voxels[v] += learnedShare * (learned.learned->voxels[v] - interpolated);
  }
  Contribution added{share[1], share[2], 0, {}};
  if (parts_.learned && !tried.learned) added.nothingLearned = " " + tried.sentence;
  if (tried.learned && !learns)
    added.nothingLearned =
        " What the slices' own detail teaches was left out: on held-out slices it did not help.";
  if (learns && !learned.learned) added.nothingLearned = " " + learned.sentence;
  const double left = meanSquare<kept>(errors, share);
  if (left > 0) added.gain = 10 * std::log10(errors[0][0] / left);
  return added;
}

Stack SlicePrediction::predict() {
  const GridGeometry& g = scan_.image.geometry;
  Stack thin;
  Volume& between = thin.image;
  between.geometry = candidateGrid(g, prepared_.outputGrid);
  const bool asked = settings_.prediction != PredictionKind::Interpolation,
             adds = asked && g.size[2] >= kFewestForTrial;
  progressed_ = progress_.state.fraction;
  costLeft_ = cost_.choosing + cost_.mixing + cost_.fit;
  if (adds) {
    voxels_ = static_cast<double>(between.geometry.voxelCount());
    if (!triesAField()) cost_.trialField = 0;
    if (!triesAField() && !keepsField_) cost_.field = 0;
    if (!parts_.learned) cost_.trial = cost_.learning = 0;
    missing_ = {missingVoxels(scan_, 0), missingVoxels(scan_, 1)};
    if (parts_.learned && !missing_[0].empty()) filling_ = cost_.trial;
    costLeft_ += cost_.trialField + cost_.trial + filling_ + cost_.learning + cost_.field;
  }
  report(progressed_);
  std::vector<float> complete = completeSlices(scan_, pool_);
  pool_.throwIfStopped();
  choice_ = chooseCandidates(scan_, complete, pool_);
  report(step(cost_.choosing, cost_.choosing).to);
  between.voxels.resize(static_cast<std::size_t>(between.geometry.voxelCount()));
  interpolate(scan_, complete, between.geometry, between.voxels);
  Contribution added;
  if (asked && !adds)
    added.nothingLearned =
        formatted(" Nothing was learned across the slices: %d are too few.", static_cast<int>(g.size[2]));
  if (adds && !(choice_.fall > 0))
    added.nothingLearned =
        " Nothing was learned across the slices: the image shows too little to judge it by.";
  if (adds && choice_.fall > 0) {
    complete = {};
    added = addCandidates(between);
  }
  complete = {};
  costLeft_ = cost_.mixing + cost_.fit;
  for (float& v : between.voxels)
    v = std::clamp(v, prepared_.range.low, prepared_.range.high);
  pool_.throwIfStopped();
  if (backProjects()) {
    BackProjectionPlan refinement;
    refinement.noise = noise_;
    refinement.range = prepared_.range;
    backProject(between, {&scan_, 1}, refinement, pool_);
  }
  sentence_ =
      "Between the slices: " + mixtureText(choice_, added.field, added.learned) +
      (choice_.judged || choice_.heldOutError[0] > 0 ? ", chosen on slices held out from the scan"
                                                     : ", because the scan shows too little for a choice") +
      (added.gain > 0.005 ? formatted(" (there %.1f dB better than interpolation alone).", added.gain)
                          : std::string(".")) +
      added.nothingLearned;
  progress_.state.note = sentence_;
  report(step(cost_.mixing, cost_.mixing).to);
  progress_.state.note.clear();
  thin.profile = SliceProfile::Point;
  thin.name = scan_.name;
  return thin;
}

} // namespace innergs
