#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/BodyMask.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobSteps.h"
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Prediction/CandidateLattice.h"
#include "Core/Prediction/SlicePredictor.h"

#include <algorithm>

/// What lies between the slices of one scan, predicted before the fit; Gaussians are fitted to it, and what
/// they leave of it is kept with them.
namespace innergs {
namespace {

constexpr double kHedge = 0.03;     // of the interpolation's squared error, added to everyone's own
constexpr double kUsualFall = 1.1;  // of linear interpolation beside the mixture, where a scan is sharp
constexpr double kLeastShare = 0.1; // of a further candidate that is worth its time

/// Every second slice.
Stack everySecond(const Stack& stack) {
  Stack half = stack;
  GridGeometry& g = half.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  half.thickness = effectiveThickness(stack);
  half.image.voxels.clear();
  half.observed.clear();
  half.times.clear();
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < g.size[2]; k += 2, ++count) {
    half.image.voxels.insert(half.image.voxels.end(), stack.image.voxels.begin() + k * plane,
                             stack.image.voxels.begin() + (k + 1) * plane);
    if (!stack.observed.empty())
      half.observed.insert(half.observed.end(), stack.observed.begin() + k * plane,
                           stack.observed.begin() + (k + 1) * plane);
  }
  g.size[2] = count;
  g.spacing[2] *= 2;
  return half;
}

Volume croppedTo(const Volume& volume, const IndexBlock& block) {
  Volume part{cropped(volume.geometry, block.first, block.size), {}};
  const auto& n = volume.geometry.size;
  for (std::int64_t k = 0; k < block.size[2]; ++k)
    for (std::int64_t j = 0; j < block.size[1]; ++j) {
      const auto row =
          volume.voxels.begin() + block.first[0] + n[0] * (block.first[1] + j + n[1] * (block.first[2] + k));
      part.voxels.insert(part.voxels.end(), row, row + block.size[0]);
    }
  return part;
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

/// A field fitted to slices alone, one member of it.
ReconstructionResult ReconstructionJob::Impl::fieldAlone(const Stack& stack, const GridGeometry& grid,
                                                         const std::stop_token& stop, double from,
                                                         double to) {
  Impl other;
  other.withheld = true; // the input is prepared as it is to be seen
  other.settings = fieldSettings(settings);
  other.input.stacks = {stack};
  other.input.outputGrid = grid;
  other.progress = [&](const Progress& p) { report(Phase::Predicting, from + (to - from) * p.fraction); };
  ReconstructionResult result = other.run(stop, false);
  if (result.cancelled) throw Error(ErrorCode::Cancelled, "Stopped on request.");
  return result;
}

/// guess += M (slices − guess seen as slices), with the mixture's interpolation M: what a guess misses of the
/// slices themselves is interpolated.
void ReconstructionJob::Impl::anchor(Volume& guess, const Stack& scan, const CandidateChoice& choice,
                                     ThreadPool& pool) const {
  const GridGeometry& g = scan.image.geometry;
  Stack rest = scan;
  const std::vector<float> seen = projectToStack(guess, scan, pool);
  for (std::size_t v = 0; v < seen.size(); ++v)
    rest.image.voxels[v] -= seen[v]; // NaN where it is not seen
  const std::vector<float> complete = completeSlices(rest, pool);
  std::vector<float> correction(guess.voxels.size());
  applyWeights(combinedWeights(choice.share, g.size[2], planePositions(g, guess.geometry)), complete,
               g.size[0] * g.size[1], correction, pool);
  for (std::size_t v = 0; v < correction.size(); ++v)
    guess.voxels[v] += correction[v];
}

/// Further candidates on a lattice between a scan's slices, anchored to them: a field fitted to the slices
/// alone, and what is learned across them. from, to: of the progress.
ReconstructionJob::Impl::Further
ReconstructionJob::Impl::furtherCandidates(const Stack& scan, const GridGeometry& grid,
                                           const CandidateChoice& choice, const Further& wanted, bool trial,
                                           ThreadPool& pool, double from, double to) {
  Further found;
  const double middle = wanted.field && wanted.learned ? 0.5 * (from + to) : wanted.field ? to : from;
  if (wanted.field) {
    found.field = fieldAlone(scan, grid, pool.stopToken(), from, middle).volume;
    anchor(*found.field, scan, choice, pool);
  }
  if (wanted.learned) {
    PredictionOptions options;
    options.effort = trial || settings.preset == Preset::Fast ? PredictionEffort::Fast
                     : settings.preset == Preset::Best        ? PredictionEffort::Best
                                                              : PredictionEffort::Balanced;
    options.grid = grid;
    options.matchingBlur = choice.blur;
    options.seed = settings.seed;
    options.instructionSet = settings.instructionSet;
    Prediction prediction = predictAcrossSlices(scan, options, pool, [&](const PredictionProgress& p) {
      report(Phase::Predicting, middle + (to - middle) * p.fraction);
    });
    found.sentence = prediction.sentence;
    if (prediction.learned) {
      found.learned = std::move(prediction.image);
      found.known = std::move(prediction.predicted);
      anchor(*found.learned, scan, choice, pool);
    }
  }
  return found;
}

/// Mixes a field fitted to the slices and what can be learned across them into the interpolation, each as far
/// as it helps where every second slice of the scan is withheld.
ReconstructionJob::Impl::Added
ReconstructionJob::Impl::addCandidates(const Stack& scan, const CandidateChoice& choice, ThreadPool& pool) {
  const GridGeometry& g = scan.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  Volume& between = fitted.front().image;
  const bool withField = static_cast<double>(between.voxels.size()) <= kMostFieldVoxels;
  const Stack even = everySecond(scan);
  GridGeometry middle = even.image.geometry; // every second plane is a withheld slice's
  middle.spacing[2] = g.spacing[2];
  middle.size[2] = 2 * even.image.geometry.size[2] - 1;
  Further wanted;
  if (withField) wanted.field.emplace();
  wanted.learned.emplace();
  const Further tried = furtherCandidates(even, middle, choice, wanted, true, pool, 0.15 * kPredictionEnds,
                                          0.4 * kPredictionEnds);
  Volume mixture{middle, std::vector<float>(static_cast<std::size_t>(middle.voxelCount()))};
  applyWeights(
      combinedWeights(choice.share, even.image.geometry.size[2], planePositions(even.image.geometry, middle)),
      completeSlices(even, pool), plane, mixture.voxels, pool);
  const Volume* guesses[3] = {&mixture, tried.field ? &*tried.field : nullptr,
                              tried.learned ? &*tried.learned : nullptr};
  // Thick slices withheld are compared with slices as thick.
  std::array<std::vector<float>, 3> seen;
  Stack all = scan;
  all.image.geometry = middle;
  all.image.voxels.assign(static_cast<std::size_t>(middle.voxelCount()), 0.f);
  all.observed.clear();
  for (int n = 0; n < 3; ++n)
    if (guesses[n]) seen[n] = projectToStack(*guesses[n], all, pool);
  const std::vector<std::uint8_t> body = bodyMask({g, completeSlices(scan, pool)}, pool.stopToken());
  Covariance errors{};
  for (std::int64_t k = 1; k < middle.size[2]; k += 2)
    for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
      const float truth = scan.image.voxels[v];
      if (!body[v] || !std::isfinite(truth) || (!scan.observed.empty() && !scan.observed[v])) continue;
      double e[3];
      for (int n = 0; n < 3; ++n)
        e[n] = guesses[n] ? static_cast<double>(seen[n][v]) - truth : 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          errors[a][b] += e[a] * e[b];
    }
  // From twice the distance to the distance itself: in smooth scans interpolation's error falls faster than
  // that of others will.
  const double rise = std::max(1.0, std::sqrt(choice.linearFall / choice.fall) / kUsualFall);
  for (int n = 1; n < 3; ++n)
    for (int m = 0; m < 3; ++m) {
      errors[n][m] *= rise;
      errors[m][n] *= rise;
    }
  for (int n = 1; n < 3; ++n)
    if (!guesses[n])
      for (int m = 0; m < 3; ++m)
        errors[n][m] = errors[m][n] = m == n ? 1e6 * errors[0][0] : 0;
  for (int n = 0; n < 3; ++n) // at twice the distance: hedged towards all
    errors[n][n] += kHedge * errors[0][0];
  auto share = convexShares({&errors, 1});
  for (int n = 1; n < 3; ++n)
    if (!guesses[n] || share[n] < kLeastShare) {
      share[0] += share[n];
      share[n] = 0;
    }
  if (share[1] > 0 && share[2] > 0) { // the two err differently; at twice the distance the field is at a loss
    const double both = share[1] + share[2];
    share[1] = 0.5 * share[1] + 0.25 * both;
    share[2] = both - share[1];
  }
  wanted = {};
  if (share[1] > 0) wanted.field.emplace();
  if (share[2] > 0) wanted.learned.emplace();
  const Further found = furtherCandidates(scan, between.geometry, choice, wanted, false, pool,
                                          0.4 * kPredictionEnds, 0.9 * kPredictionEnds);
  const auto field = static_cast<float>(found.field ? share[1] : 0),
             learned = static_cast<float>(found.learned ? share[2] : 0);
  for (std::size_t v = 0; v < between.voxels.size(); ++v) {
    const float interpolated = between.voxels[v];
    if (found.field) between.voxels[v] += field * (found.field->voxels[v] - interpolated);
    if (found.learned && (found.known.empty() || found.known[v]))
      between.voxels[v] += learned * (found.learned->voxels[v] - interpolated);
  }
  return {field, learned, tried.learned ? std::string() : " " + tried.sentence};
}

void ReconstructionJob::Impl::predict(const PreparedInput& prepared, ThreadPool& pool,
                                      ReconstructionResult& result) {
  fitted.clear();
  predicted = false;
  if (!predicts(settings, traits)) return;
  const Stack& scan = prepared.stacks.front();
  const GridGeometry& g = scan.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  const auto told = [&](double share) {
    report(Phase::Predicting, 0.01 + (kPredictionEnds - 0.01) * share);
    pool.throwIfStopped();
  };
  told(0);
  std::vector<float> complete = completeSlices(scan, pool);
  told(0.02);
  const CandidateChoice choice = chooseCandidates(scan, complete, pool);
  told(0.1);
  Volume& between = fitted.emplace_back().image;
  between.geometry = predictionLattice(g, prepared.outputGrid);
  between.voxels.resize(static_cast<std::size_t>(between.geometry.voxelCount()));
  applyWeights(combinedWeights(choice.share, g.size[2], planePositions(g, between.geometry)), complete, plane,
               between.voxels, pool);
  told(0.15);
  Added added;
  if (settings.prediction != PredictionKind::Interpolation && choice.fall > 0 && g.size[2] >= 6) {
    complete = {};
    added = addCandidates(scan, choice, pool);
  }
  complete = {};
  for (float& v : between.voxels)
    v = std::clamp(v, prepared.range.low, prepared.range.high);
  told(0.9);
  if (settings.consistency && choice.backProject && scan.profile != SliceProfile::Point) {
    BackProjectionPlan refinement;
    refinement.noise = traits.noise * map.scale;
    refinement.range = prepared.range;
    backProject(between, {&scan, 1}, refinement, pool);
  }
  result.prediction = "Between the slices: " + mixtureText(choice, added.field, added.learned) +
                      ", as slices withheld from the scan suggest." + added.nothingLearned;
  state.note = result.prediction;
  told(1);
  state.note.clear();
  Stack& thin = fitted.front();
  thin.profile = SliceProfile::Point;
  thin.name = scan.name;
  if (!prepared.support.voxels.empty()) {
    if (const auto block = blockOver(thin.image.geometry, boxOf(prepared.support.geometry)))
      thin.image = croppedTo(thin.image, *block);
    thin.observed = resampleMask(prepared.support, thin.image.geometry, pool.stopToken());
  }
  predicted = true;
}

/// What the Gaussians leave of the prediction, on its own lattice: with it the model is the prediction there.
void ReconstructionJob::Impl::keepPrediction(const PreparedInput& prepared, ThreadPool& pool,
                                             ReconstructionResult& result) {
  GaussianField& field = model.field;
  report(Phase::Refining, kFitEnds);
  RenderOptions options = renderOptions(field, pool.stopToken());
  options.bounded = false;
  Volume rest = render(field, fitted.front().image.geometry, options);
  const std::vector<float>& wanted = fitted.front().image.voxels;
  const auto scale = static_cast<float>(1 / field.intensityScale);
  pool.blocks(static_cast<std::int64_t>(wanted.size()), 1 << 20, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v)
      rest.voxels[v] = (wanted[v] - rest.voxels[v]) * scale;
  });
  field.residual = std::move(rest);
  const Stack& scan = prepared.stacks.front();
  const std::vector<float> seen = projectToStack(fitted.front().image, scan, pool);
  double squared = 0;
  std::int64_t count = 0;
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const double e = (static_cast<double>(seen[v]) - scan.image.voxels[v]) * scale;
    if (!std::isfinite(e)) continue;
    squared += e * e;
    ++count;
  }
  result.trainingPsnr = state.trainingPsnr =
      psnrOf(squared / static_cast<double>(std::max<std::int64_t>(1, count)));
}

} // namespace innergs
