#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/BodyMask.h"
#include "Core/Job/JobSteps.h"
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Prediction/CandidateLattice.h"

#include <algorithm>

/// What lies between the slices of one scan, predicted before the fit; Gaussians are fitted to it, and what
/// they leave of it is kept with them.
namespace innergs {
namespace {

constexpr double kMostFieldVoxels = 40e6; // of a prediction that a field fitted to the slices takes part in
constexpr double kWorthwhile = 0.995;     // error that a further candidate must bring the mixture's down to

/// Every second slice, from the first.
Stack everySecond(const Stack& stack, std::int64_t first) {
  Stack half = stack;
  GridGeometry& g = half.image.geometry;
  const std::int64_t plane = g.size[0] * g.size[1];
  half.thickness = effectiveThickness(stack);
  half.image.voxels.clear();
  half.observed.clear();
  half.times.clear();
  std::int64_t count = 0;
  for (std::int64_t k = first; k < g.size[2]; k += 2, ++count) {
    half.image.voxels.insert(half.image.voxels.end(), stack.image.voxels.begin() + k * plane,
                             stack.image.voxels.begin() + (k + 1) * plane);
    if (!stack.observed.empty())
      half.observed.insert(half.observed.end(), stack.observed.begin() + k * plane,
                           stack.observed.begin() + (k + 1) * plane);
  }
  g.origin = g.indexToWorld()({0, 0, static_cast<double>(first)});
  g.size[2] = count;
  g.spacing[2] *= 2;
  return half;
}

std::string mixtureText(const CandidateChoice& choice) {
  std::string text;
  for (int c = 0; c < kCandidates; ++c)
    if (choice.share[c] > 0)
      text += (text.empty() ? "" : " and ") + formatted("%.0f %% ", 100 * choice.share[c]) +
              candidateName(static_cast<Candidate>(c));
  return text + " interpolation";
}

} // namespace

/// A field fitted to slices alone, one member of it.
ReconstructionResult ReconstructionJob::Impl::fieldAlone(const Stack& stack, const GridGeometry& grid,
                                                         const std::stop_token& stop, double from, double to) {
  Impl other;
  other.withheld = true; // the input is prepared as it is to be seen
  other.settings.preset = settings.preset == Preset::Fast ? Preset::Fast : Preset::Balanced;
  other.settings.prediction = PredictionKind::None;
  other.settings.ensembleSize = 1;
  other.settings.consistency = settings.consistency;
  other.settings.threads = settings.threads;
  other.settings.instructionSet = settings.instructionSet;
  other.settings.device = settings.device;
  other.settings.seed = settings.seed;
  other.input.stacks = {stack};
  other.input.outputGrid = grid;
  other.progress = [&](const Progress& p) { report(Phase::Predicting, from + (to - from) * p.fraction); };
  ReconstructionResult result = other.run(stop, false);
  if (result.cancelled) throw Error(ErrorCode::Cancelled, "Stopped on request.");
  return result;
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
  Stack& thin = fitted.emplace_back();
  thin.image.geometry = predictionLattice(g, prepared.outputGrid);
  thin.image.voxels.resize(static_cast<std::size_t>(thin.image.geometry.voxelCount()));
  applyWeights(combinedWeights(choice.share, g.size[2], planePositions(g, thin.image.geometry)), complete,
               plane, thin.image.voxels, pool);
  told(0.15);
  result.prediction = "Between the slices: " + mixtureText(choice);
  double fieldShare = 0;
  const bool withField = settings.prediction != PredictionKind::Interpolation && choice.fall > 0 &&
                         g.size[2] >= 6 &&
                         static_cast<double>(thin.image.voxels.size()) <= kMostFieldVoxels;
  if (withField) {
    const Stack even = everySecond(scan, 0), odd = everySecond(scan, 1);
    const ReconstructionResult half =
        fieldAlone(even, odd.image.geometry, pool.stopToken(), 0.15 * kPredictionEnds, 0.4 * kPredictionEnds);
    RenderOptions options = renderOptions(half.checkpoint->field, pool.stopToken());
    const Volume field = renderStack(half.checkpoint->field, odd, options);
    std::vector<double> at;
    for (std::int64_t k = 1; k < g.size[2]; k += 2)
      at.push_back(0.5 * static_cast<double>(k));
    std::vector<float> mixture(field.voxels.size());
    applyWeights(combinedWeights(choice.share, even.image.geometry.size[2], at),
                 completeSlices(even, pool), plane, mixture, pool);
    std::vector<std::uint8_t> body = bodyMask({g, complete}, pool.stopToken());
    Covariance c{};
    double count = 0;
    for (std::int64_t k = 1, n = 0; k + 1 < g.size[2]; k += 2, ++n)
      for (std::int64_t p = 0; p < plane; ++p) {
        const std::int64_t v = k * plane + p;
        const float truth = scan.image.voxels[v];
        if (!body[v] || !std::isfinite(truth) || (!scan.observed.empty() && !scan.observed[v])) continue;
        const double a = static_cast<double>(mixture[n * plane + p]) - truth,
                     b = static_cast<double>(field.voxels[n * plane + p]) - truth;
        c[0][0] += a * a;
        c[0][1] += a * b;
        c[1][1] += b * b;
        ++count;
      }
    // From twice the distance to the distance itself; the field gains no more than linear interpolation does.
    const double fall[2] = {choice.fall, choice.linearFall};
    if (count > 0) {
      c[0][0] *= fall[0] * fall[0];
      c[0][1] *= fall[0] * fall[1];
      c[1][1] *= fall[1] * fall[1];
      const double spread = c[0][0] + c[1][1] - 2 * c[0][1];
      if (spread > 0) fieldShare = std::clamp((c[0][0] - c[0][1]) / spread, 0.0, 1.0);
      const double mixed = (1 - fieldShare) * (1 - fieldShare) * c[0][0] +
                           2 * fieldShare * (1 - fieldShare) * c[0][1] + fieldShare * fieldShare * c[1][1];
      if (!(mixed < kWorthwhile * c[0][0])) fieldShare = 0;
    }
  }
  complete = {};
  if (fieldShare > 0) {
    const Volume field = fieldAlone(scan, thin.image.geometry, pool.stopToken(), 0.4 * kPredictionEnds,
                                    0.9 * kPredictionEnds)
                             .volume;
    const auto share = static_cast<float>(fieldShare);
    for (std::size_t v = 0; v < field.voxels.size(); ++v)
      thin.image.voxels[v] += share * (field.voxels[v] - thin.image.voxels[v]);
    result.prediction += formatted(", with %.0f %% of a field fitted to the slices", 100 * fieldShare);
  }
  for (float& v : thin.image.voxels)
    v = std::clamp(v, prepared.range.low, prepared.range.high);
  told(0.9);
  if (settings.consistency && choice.backProject && scan.profile != SliceProfile::Point) {
    BackProjectionPlan refinement;
    refinement.noise = traits.noise * map.scale;
    refinement.range = prepared.range;
    backProject(thin.image, {&scan, 1}, refinement, pool);
  }
  result.prediction += ", as slices withheld from the scan suggest.";
  state.note = result.prediction;
  told(1);
  state.note.clear();
  thin.profile = SliceProfile::Point;
  thin.name = scan.name;
  if (!prepared.support.voxels.empty())
    thin.observed = resampleMask(prepared.support, thin.image.geometry, pool.stopToken());
  predicted = true;
}

/// What the Gaussians leave of the prediction, on its own lattice: with it the model is the prediction there.
void ReconstructionJob::Impl::keepPrediction(const PreparedInput& prepared, ThreadPool& pool,
                                             ReconstructionResult& result) {
  GaussianField& field = checkpoint.field;
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
