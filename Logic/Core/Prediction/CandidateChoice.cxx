#include "Core/Prediction/CandidateChoice.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Image/BodyMask.h"
#include "Core/Prediction/SliceSimulation.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr double kBlurs[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1}; // in slice distances
constexpr int kPlausible = 3;                                          // blurs that the choice hedges between
constexpr double kNearlyAsGood = 0.8;                                  // weight of a blur
constexpr double kTemperature = 0.2; // of misfits: a blur that fits worse by this much counts 1/e as much
constexpr int kClassical = 3;        // candidates without a blur
constexpr double kKrigingBlurs[] = {0, 0.15, 0.25, 0.35, 0.5, 0.7, 1}; // in slice distances
constexpr double kAsGood = 1.01;                                       // ratio of squared errors
constexpr double kSlope = 0.5, kLevel = 0.1; // weights of slopes and of the errors' size in a misfit
constexpr double kMostChange = 0.5;          // of a misfit, by the change of detail
constexpr double kHeldOut = 0.5;             // weight of held-out slices, beside simulated ones
constexpr double kLoss = 3;                  // weight of a loss, beside a gain
constexpr double kRounding = 1e-9;           // of the worst candidate's squared error

/// What a scan shows of itself.
struct ScanTraits {
  CandidateErrors heldOut;        // from heldOutErrors()
  double slope = 0;               // slopeShare()
  std::array<double, 2> change{}; // changeShare() of the detail along either axis; 0: unknown

  bool shown() const { return heldOut.samples >= kFewestSamples; }
};

/// How far a simulation is from what the scan shows by its contrast.
double contrastMisfit(const SliceSimulation& s, const ScanTraits& scan) {
  double sum = 0;
  const Covariance<kCandidates> a = s.heldOut.mean(), b = scan.heldOut.mean();
  for (int c = 1; c < kClassical; ++c)
    if (a[0][0] > 0 && b[0][0] > 0 && a[c][c] > 0 && b[c][c] > 0)
      sum += std::abs(std::log(a[c][c] / a[0][0]) - std::log(b[c][c] / b[0][0]));
  if (scan.slope > 0 && s.slope() > 0) sum += kSlope * std::abs(std::log(s.slope() / scan.slope));
  // Only a hint: contrast along the slices differs from that across them.
  if (a[0][0] > 0 && b[0][0] > 0) sum += kLevel * std::abs(std::log(a[0][0] / b[0][0]));
  return sum;
}

/// Likewise, by how its detail changes between slices.
double detailMisfit(const SliceSimulation& s, const ScanTraits& scan) {
  double simulated = 0, seen = 0;
  for (int axis = 0; axis < 2; ++axis)
    if (s.change[axis] > 0 && scan.change[axis] > 0) {
      simulated += s.change[axis];
      seen += scan.change[axis];
    }
  // More than that, structures differ along the slices and across them.
  return seen > 0 ? std::min(kMostChange, std::abs(std::log(simulated / seen))) : 0;
}

/// Weighs the simulations by how well they fit, keeps the best ones, and returns the blur (mm) for learning,
/// which suffers more from too much of it than from too little: the least that fits about best, or best by
/// contrast alone.
double keepPlausible(std::vector<SliceSimulation>& simulations, const ScanTraits& scan) {
  std::vector<double> contrast, misfits;
  for (const SliceSimulation& s : simulations) {
    contrast.push_back(contrastMisfit(s, scan));
    misfits.push_back(contrast.back() + detailMisfit(s, scan));
  }
  const double least = *std::min_element(misfits.begin(), misfits.end());
  double sharpest = simulations[std::min_element(contrast.begin(), contrast.end()) - contrast.begin()].blur;
  for (std::size_t n = 0; n < simulations.size(); ++n)
    simulations[n].weight = std::exp((least - misfits[n]) / kTemperature);
  std::stable_sort(simulations.begin(), simulations.end(),
                   [](const SliceSimulation& a, const SliceSimulation& b) { return a.weight > b.weight; });
  simulations.resize(std::min<std::size_t>(simulations.size(), kPlausible));
  for (const SliceSimulation& s : simulations)
    if (s.weight >= kNearlyAsGood) sharpest = std::min(sharpest, s.blur);
  return sharpest;
}

/// The covariance on held-out slices, converted by the simulation from twice the slice distance to the
/// distance itself.
Covariance<kCandidates> calibrated(const Covariance<kCandidates>& heldOut,
                                   const Covariance<kCandidates>& near, const Covariance<kCandidates>& far) {
  Covariance<kCandidates> result = heldOut;
  for (int a = 0; a < kCandidates; ++a)
    for (int b = 0; b < kCandidates; ++b)
      result[a][b] *= std::sqrt(near[a][a] / far[a][a] * near[b][b] / far[b][b]);
  return result;
}

double leastClassical(const Covariance<kCandidates>& errors) {
  double least = errors[0][0];
  for (int c = 1; c < kClassical; ++c)
    least = std::min(least, errors[c][c]);
  return least;
}

/// What may lie between the slices.
struct Case {
  Covariance<kCandidates> errors;
  double weight = 1;
};

/// The shares that gain most over the best classical candidate, in the weighted mean of the cases, in dB.
std::array<double, kCandidates> bestShares(std::span<const Case> cases) {
  return convexShares<kCandidates>([&](const std::array<double, kCandidates>& share) {
    double cost = 0;
    for (const Case& c : cases) {
      double worst = 0;
      for (int n = 0; n < kCandidates; ++n)
        worst = std::max(worst, c.errors[n][n]);
      if (!(worst > 0)) continue;
      const double rounding = kRounding * worst;
      const double loss = std::log((std::max(0.0, meanSquare(c.errors, share)) + rounding) /
                                   (leastClassical(c.errors) + rounding));
      cost += c.weight * (loss > 0 ? kLoss * loss : loss);
    }
    return cost;
  });
}

std::array<double, kCandidates> rootsOf(const Covariance<kCandidates>& errors) {
  std::array<double, kCandidates> roots;
  for (int c = 0; c < kCandidates; ++c)
    roots[c] = std::sqrt(errors[c][c]);
  return roots;
}

/// The kriging's blur, in slice distances, that gains most over the best classical candidate, in the weighted
/// mean of the simulations, in dB.
double bestKrigingBlur(std::span<const SliceSimulation> simulations, ThreadPool& pool) {
  constexpr auto k = static_cast<std::size_t>(Candidate::Kriging);
  const std::size_t blurs = std::size(kKrigingBlurs), axes = simulations.front().images.size();
  struct Pair {
    CandidateErrors plain, projected;
  };
  std::vector<std::vector<Pair>> errors(blurs * axes, std::vector<Pair>(simulations.size()));
  pool.run(static_cast<std::int64_t>(errors.size()), [&](std::int64_t n) {
    const std::size_t axis = n % axes;
    const DegradedImages& any = simulations.front().images[axis]; // the geometry is that of all
    const LineWeights weights = lineWeights(any, kKrigingBlurs[n / axes], static_cast<int>(k));
    for (std::size_t s = 0; s < simulations.size(); ++s)
      addErrors(simulations[s].images[axis], weights, errors[n][s].plain, errors[n][s].projected);
  });
  std::vector<double> excess(blurs, 0.0);
  double weights = 0;
  for (std::size_t s = 0; s < simulations.size(); ++s) {
    const Covariance<kCandidates> classical = simulations[s].best().mean();
    weights += simulations[s].weight;
    const double least = leastClassical(classical);
    for (std::size_t blur = 0; blur < blurs && least > 0; ++blur) {
      Pair sum;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        sum.plain.add(errors[blur * axes + axis][s].plain);
        sum.projected.add(errors[blur * axes + axis][s].projected);
      }
      const CandidateErrors& best = sum.projected.samples > 0 ? sum.projected : sum.plain;
      excess[blur] += simulations[s].weight * std::log(best.mean()[k][k] / least);
    }
  }
  // Takes the largest of equally good blurs: scans are smoother than slices held out from each other suggest.
  const double enough = *std::min_element(excess.begin(), excess.end()) + weights * std::log(kAsGood);
  std::size_t chosen = excess.size() - 1;
  while (excess[chosen] > enough)
    --chosen;
  return kKrigingBlurs[chosen];
}

} // namespace

CandidateChoice chooseCandidates(const Stack& stack, std::span<const float> complete, ThreadPool& pool) {
  CandidateChoice choice;
  const GridGeometry& g = stack.image.geometry;
  std::vector<std::uint8_t>& inside = choice.inside;
  inside = bodyMask({g, {complete.begin(), complete.end()}}, pool.stopToken());
  for (std::size_t v = 0; v < inside.size(); ++v)
    inside[v] = inside[v] && isKnown(stack, v);
  const std::vector<std::int64_t> columns = voxelsAcross(g);
  const SliceLines across = linesAt(columns, g.size[2], complete, inside);
  const SliceView view{stack.profile, effectiveThickness(stack) / g.spacing[2]};
  InPlaneLines within[2];
  ScanTraits scan;
  pool.run(4, [&](std::int64_t n) {
    const int axis = static_cast<int>(n % 2);
    if (n < 2) {
      const std::vector<std::int64_t> voxels = voxelsWithin(g, axis);
      within[axis] = {linesAt(voxels, g.size[axis], complete, inside),
                      detailAt(voxels, g.size[axis], g, complete, inside, 1 - axis)};
    } else if (isJudgedBy(g, 1 - axis)) {
      scan.change[axis] = changeShare(detailAt(columns, g.size[2], g, complete, inside, axis));
    }
  });
  std::vector<SliceSimulation> simulations(std::size(kBlurs));
  pool.run(static_cast<std::int64_t>(simulations.size()),
           [&](std::int64_t n) { simulations[n] = simulateSlices(within, stack, kBlurs[n] * g.spacing[2]); });
  std::vector<LineWeights> weights = weightsOfAxes(simulations.front(), 0);
  pool.run(static_cast<std::int64_t>(simulations.size()) + 1, [&](std::int64_t n) {
    if (n == 0) {
      scan.heldOut = heldOutErrors(across, view, 0);
      scan.slope = slopeShare(across);
    } else {
      measureCandidates(simulations[n - 1], 0, weights);
    }
  });
  const bool shown = scan.shown();
  std::erase_if(simulations, [](const SliceSimulation& s) { return s.plain.samples < kFewestSamples; });
  if (simulations.empty()) {
    if (shown) {
      choice.share = convexShares<kCandidates>(scan.heldOut.mean());
      choice.heldOutError = rootsOf(scan.heldOut.mean());
    }
    return choice;
  }
  double sharpest = simulations.front().blur;
  if (shown || scan.change[0] + scan.change[1] > 0)
    sharpest = keepPlausible(simulations, scan);
  else
    simulations.resize(1);
  const double krigingBlur = bestKrigingBlur(simulations, pool);
  choice.krigingBlur = krigingBlur * g.spacing[2];
  if (krigingBlur > 0) {
    weights = weightsOfAxes(simulations.front(), krigingBlur);
    pool.run(static_cast<std::int64_t>(simulations.size()) + 1, [&](std::int64_t n) {
      if (n == 0)
        scan.heldOut = heldOutErrors(across, view, krigingBlur);
      else
        measureCandidates(simulations[n - 1], krigingBlur, weights);
    });
  }
  if (shown) choice.heldOutError = rootsOf(scan.heldOut.mean());
  const SliceSimulation& nearest = simulations.front();
  choice.judged = true;
  choice.blur = sharpest / std::min(g.spacing[0], g.spacing[1]);
  choice.backProject = nearest.projected.samples > 0;
  std::vector<Case> cases;
  for (const SliceSimulation& s : simulations) {
    const Covariance<kCandidates> near = s.best().mean(), seen = scan.heldOut.mean();
    cases.push_back({near, s.weight});
    if (!shown) continue;
    const bool comparable = s.heldOut.samples >= kFewestSamples;
    cases.push_back({comparable ? calibrated(seen, near, s.heldOut.mean()) : seen, kHeldOut * s.weight});
  }
  choice.share = bestShares(cases);
  const Covariance<kCandidates> pairs = nearest.best().mean();
  choice.pairError = rootsOf(pairs);
  choice.error = std::sqrt(std::max(0.0, meanSquare(pairs, choice.share)));
  const Covariance<kCandidates> far = nearest.heldOut.mean();
  if (far[0][0] > 0 && meanSquare(far, choice.share) > 0) {
    choice.linearFall = std::sqrt(pairs[0][0] / far[0][0]);
    choice.fall = std::sqrt(meanSquare(pairs, choice.share) / meanSquare(far, choice.share));
  }
  return choice;
}

} // namespace innergs
