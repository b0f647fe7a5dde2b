#include "Core/Fit/Plan.h"

#include "Core/Base/Error.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/NoiseEstimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace innergs {
namespace {

constexpr std::int64_t kPaperGaussians = 42 * 42 * 42;
constexpr std::int64_t kFewestGaussians = 64;
constexpr double kTypicalNoise = 0.009, kTypicalDisagreement = 0.025; // of the intensity range, for estimates

template <class Visit>
void forEachSample(std::span<const Stack> stacks, Visit&& visit) {
  for (const Stack& stack : stacks)
    for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
      if (isKnown(stack, v)) visit(stack.image.voxels[v]);
}

constexpr std::int64_t kVolumeSamples = 500'000; // per stack, roughly, to measure the volume that several see

/// Whether a counted voxel of the stack contains the point, given in stack indices without slice poses.
template <class Counts>
bool holds(const Stack& stack, const Vec3& index, const Counts& counts) {
  const auto& size = stack.image.geometry.size;
  std::int64_t nearest[3];
  for (int a = 0; a < 3; ++a) {
    nearest[a] = std::llround(index[a]);
    if (nearest[a] < 0 || nearest[a] >= size[a]) return false;
  }
  return counts(stack, nearest[0] + size[0] * (nearest[1] + size[1] * nearest[2]));
}

/// Volume (mm³) of places, each once even if several stacks see it.
struct SeenVolume {
  double all = 0, byOne = 0; // by any stack, by only one
};

/// Of the counted voxels.
template <class Counts>
SeenVolume seenVolume(std::span<const Stack> stacks, const Counts& counts) {
  std::vector<std::vector<Affine3>> toIndex; // one map, or one per posed slice
  for (const Stack& stack : stacks) {
    const Affine3 map = stack.image.geometry.indexToWorld();
    auto& maps = toIndex.emplace_back();
    for (const Affine3& pose : stack.poses)
      maps.push_back(inverse(pose * map));
    if (stack.poses.empty()) maps.push_back(inverse(map));
  }
  std::vector<double> parts, partsByOne;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    const Stack& stack = stacks[s];
    const GridGeometry& g = stack.image.geometry;
    const std::int64_t voxels = g.voxelCount();
    std::int64_t counted = 0;
    for (std::int64_t v = 0; v < voxels; ++v)
      counted += counts(stack, v);
    const Vec3 extent = g.extent();
    const double own =
        extent[0] * extent[1] * extent[2] * static_cast<double>(counted) / static_cast<double>(voxels);
    if (stacks.size() == 1) return {own, own};
    std::int64_t step = 1;
    for (const std::int64_t prime : {7, 61, 509, 4001})
      if (counted / step > kVolumeSamples) step = prime;
    const Affine3 map = g.indexToWorld();
    std::vector<std::int64_t> seenBy(stacks.size() + 1, 0);
    std::int64_t visited = 0, next = 0;
    for (std::int64_t v = 0; v < voxels; ++v) {
      if (!counts(stack, v) || next++ % step) continue;
      ++visited;
      const std::int64_t i = v % g.size[0], j = v / g.size[0] % g.size[1], k = v / (g.size[0] * g.size[1]);
      Vec3 point = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      if (!stack.poses.empty()) point = stack.poses[k](point);
      int by = 1;
      for (std::size_t o = 0; o < stacks.size(); ++o) {
        bool seen = false;
        for (std::size_t slice = 0; o != s && slice < toIndex[o].size() && !seen; ++slice) {
          const Vec3 index = toIndex[o][slice](point);
          seen = (stacks[o].poses.empty() || std::llround(index[2]) == static_cast<std::int64_t>(slice)) &&
                 holds(stacks[o], index, counts);
        }
        by += seen;
      }
      ++seenBy[by];
    }
    double once = 0;
    for (std::size_t n = 1; n < seenBy.size(); ++n)
      once += static_cast<double>(seenBy[n]) / static_cast<double>(n);
    if (visited == 0) continue;
    parts.push_back(own * once / static_cast<double>(visited));
    partsByOne.push_back(own * static_cast<double>(seenBy[1]) / static_cast<double>(visited));
  }
  const auto sum = [](std::vector<double>& terms) {
    std::sort(terms.begin(), terms.end()); // makes the sum independent of the stacks' order
    return std::accumulate(terms.begin(), terms.end(), 0.0);
  };
  return {sum(parts), sum(partsByOne)};
}

constexpr double kMostlyBeside = 0.6; // of the volume, seen by one stack only

bool haveDistantSlices(std::span<const Stack> stacks) {
  return std::all_of(stacks.begin(), stacks.end(), [](const Stack& stack) {
    const Vec3& s = stack.image.geometry.spacing;
    return stack.poses.empty() && s[2] > 1.4 * std::min(s[0], s[1]);
  });
}

} // namespace

IntensityMap chooseIntensityMap(std::span<const Stack> stacks) {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  std::int64_t count = 0;
  forEachSample(stacks, [&](float v) {
    low = std::min(low, v);
    high = std::max(high, v);
    ++count;
  });
  if (!(high > low)) return {1.0, count ? low : 0.0};
  constexpr int kBins = 1 << 16;
  std::vector<std::int64_t> histogram(kBins, 0);
  const double width = (static_cast<double>(high) - low) / kBins;
  forEachSample(stacks, [&](float v) {
    ++histogram[std::min<std::int64_t>(kBins - 1,
                                       static_cast<std::int64_t>((v - static_cast<double>(low)) / width))];
  });
  const std::int64_t outliers = count / 10000;
  std::int64_t below = 0, above = 0;
  int first = 0, last = kBins - 1;
  while (first < last && below + histogram[first] <= outliers)
    below += histogram[first++];
  while (last > first && above + histogram[last] <= outliers)
    above += histogram[last--];
  const double bottom = low + width * first, top = low + width * (last + 1);
  return {top - bottom, bottom};
}

DataTraits geometryTraits(std::span<const Stack> stacks) {
  DataTraits t;
  t.stacks = static_cast<int>(stacks.size());
  t.voxel = std::numeric_limits<double>::max();
  t.gap = 0;
  for (const Stack& stack : stacks) {
    const Vec3& spacing = stack.image.geometry.spacing;
    t.voxel = std::min({t.voxel, spacing[0], spacing[1]});
    t.gap = std::max(t.gap, spacing[2]);
  }
  for (const Stack& stack : stacks)
    if (stack.profile != SliceProfile::Point && effectiveThickness(stack) > 1.4 * t.voxel)
      t.thickness = std::max(t.thickness, effectiveThickness(stack));
  const SeenVolume seen = seenVolume(stacks, [](const Stack&, std::size_t) { return true; });
  t.volume = seen.all;
  t.adjoining = stacks.size() > 1 && seen.byOne >= kMostlyBeside * seen.all && haveDistantSlices(stacks);
  t.region = std::any_of(stacks.begin(), stacks.end(), [](const Stack& s) { return s.isRegion; });
  const Stack& first = stacks.front();
  const Vec3& spacing = first.image.geometry.spacing;
  const auto [low, high] = std::minmax({spacing[0], spacing[1], spacing[2]});
  for (const Stack& stack : stacks)
    t.posed = t.posed || !stack.poses.empty();
  t.noise = kTypicalNoise;
  t.cubes = stacks.size() == 1 && first.poses.empty() && t.thickness == 0 && high <= 1.4 * low;
  return t;
}

DataTraits withMovedSlices(DataTraits traits) {
  traits.posed = true;
  traits.disagreement = kTypicalDisagreement;
  return traits;
}

bool predicts(const Settings& settings, const DataTraits& traits) {
  return settings.prediction != PredictionKind::None && settings.preset != Preset::Paper &&
         chosenBlending(settings) == Blending::Normalised && !traits.posed &&
         (traits.singleAnisotropic() || (traits.adjoining && traits.superResolution()));
}

bool addsResidual(const Settings& settings, const DataTraits& traits) {
  if (!settings.consistency || traits.posed) return false;
  return traits.thickness > 0 || (!traits.superResolution() && settings.preset != Preset::Paper &&
                                  chosenBlending(settings) == Blending::Normalised);
}

double noiseOf(std::span<const Stack> stacks, const IntensityMap& map) {
  double noise = 0;
  for (const Stack& stack : stacks)
    noise = std::max(noise, estimateNoise(stack.image, stack.observed) / map.scale);
  return noise;
}

DataTraits measureTraits(std::span<const Stack> stacks, const IntensityMap& map) {
  DataTraits t = geometryTraits(stacks);
  t.noise = noiseOf(stacks, map);
  forEachSample(stacks, [&](float) { ++t.samples; });
  t.volume = seenVolume(stacks, [](const Stack& stack, std::size_t v) {
               return std::isfinite(stack.image.voxels[v]);
             }).all;
  return t;
}

namespace {

/// Fills in the preset's choices where neither the user nor the data decide.
void fillChoices(Settings& s, const DataTraits& traits) {
  s = withPresetValues(s);
  if (!s.linearIntensity)
    s.linearIntensity = s.blending == Blending::Normalised && s.preset != Preset::Paper &&
                        (!traits.superResolution() || predicts(s, traits));
  if (s.allAxes.value_or(false) && !traits.cubes)
    throw Error(ErrorCode::InvalidArgument, "Slices along all axes need one scan of thin slices whose voxels "
                                            "are nearly cubes: omit that option.");
  if (!s.allAxes) s.allAxes = *s.blending == Blending::Alpha && traits.cubes;
}

constexpr double kMiddleNoise = 0.014;      // of the intensity range, for a preset's iterations
constexpr double kDisagreementShare = 0.25; // counted as noise; the rest is what single scans do not show
constexpr double kFewer = 0.4, kMore = 2;   // of them, at least and at most
// Slices that moved: fewer Gaussians invent less between them, and are fitted for longer; the more so if
// merging members averages the noise that they fit.
constexpr double kLongerIfMoved = 1.5, kLongerIfMerged = 1.25;
// They also start narrower and more evenly, and turn more slowly: between slices at irregular distances their
// directions are known least.
constexpr double kScaleIfMoved = 0.85, kEvenShareIfMoved = 0.3, kTurnIfMoved = 0.5;
/// Several scans: where each iteration takes one subset of them, Gaussians may move faster and for longer.
constexpr int kMostSubsets = 3;
constexpr double kSubsetRates = 1.5, kSubsetFinalRate = 0.1;
constexpr double kWidest = 1.5; // mean distances: in mere noise, Gaussians would grow without end

constexpr double kThinNoise = 0.01; // of the intensity range: thin slices with less are fitted for longest

/// Iterations for thin slices: their residual grid keeps what is missed, so more would only fit the noise.
int thinIterations(int fewest, int most, const DataTraits& traits) {
  const double noise = traits.noise / std::sqrt(static_cast<double>(traits.stacks));
  const double share = std::min(1.0, std::pow(kThinNoise / std::max(noise, 1e-9), 1.5));
  return std::max(fewest, static_cast<int>(std::lround(most * share)));
}

/// Whether the fit compares the losses of its iterations, so that all must have the same data.
bool comparesLosses(const Settings& filled) {
  return *filled.paperStopRule || *filled.schedule == Schedule::Plateau;
}

/// Number of Gaussians and iterations; for distant slices, also the layout and bounds of the Gaussians.
void planAmount(Settings& settings, const DataTraits& traits, FitPlan& plan) {
  const int level = settings.preset == Preset::Fast ? 0 : settings.preset == Preset::Balanced ? 1 : 2;
  const double volume = traits.volume * traits.reached.gaussians;
  const double voxels = volume / (traits.voxel * traits.voxel * traits.voxel);
  std::int64_t budget;
  int iterations, members = 1;
  double widest = 0; // standard deviation relative to the mean distance of Gaussians; 0: no such limit
  if (settings.preset == Preset::Paper) {
    plan.start.equalCounts = true;
    budget = std::llround(kPaperGaussians * traits.reached.gaussians);
    iterations = 1000;
  } else if (predicts(settings, traits)) {
    budget = static_cast<std::int64_t>(voxels / std::array{100.0, 60.0, 30.0}[level]);
    // The residual grid keeps what they miss, except noise, which more iterations would fit.
    const double quiet = kMiddleNoise / std::max(traits.noise, 1e-9);
    iterations = level == 0   ? 9
                 : level == 1 ? 12
                              : static_cast<int>(std::lround(std::clamp(60 * quiet * quiet, 12.0, 60.0)));
    plan.coarseIterations = std::array{8, 8, 20}[level];
  } else if (traits.singleAnisotropic()) {
    // Overlapping Gaussians (0.9 spacings wide) that bridge the gap and are free to turn: they shear along
    // structures.
    const double gap = traits.gap, inPlane = std::min(gap, 4 * traits.voxel);
    plan.start.kind = Initialisation::Grid;
    plan.start.layerSpacing = gap;
    plan.start.layerSigma = 1.25 * gap;
    plan.start.scaleFactor = 0.9;
    plan.bounds.minThirdLogScale = std::log(1.125 * gap);
    plan.bounds.minLogScale = std::log(0.5 * traits.voxel);
    plan.smoothAlongNormal = true;
    plan.rates.mean = 0.3 * traits.voxel;
    plan.rates.quaternion = 0.15;
    budget = static_cast<std::int64_t>(volume / (inPlane * inPlane * gap));
    iterations = std::array{40, 60, 60}[level];
    members = std::array{1, 4, 8}[level];
    plan.coarseIterations = 30;
  } else if (traits.superResolution()) {
    plan.start.scaleFactor = 0.9;
    plan.bounds.minLogScale = std::log(0.5 * traits.voxel);
    widest = kWidest;
    const bool moved = traits.disagreement > 0;
    budget = static_cast<std::int64_t>(voxels / (moved ? 50.0 : std::array{50.0, 25.0, 25.0}[level]));
    // Weak noise is worth a closer fit, strong noise would be fitted, too, and so would what moved slices
    // disagree by.
    const double wrong = std::max({traits.noise, kDisagreementShare * traits.disagreement, 1e-9});
    const double longer = traits.posed && traits.disagreement <= 0
                              ? 1
                              : std::clamp(std::sqrt(kMiddleNoise / wrong), kFewer, kMore);
    members = std::array{1, moved ? 3 : 1, 3}[level];
    const double further = moved ? kLongerIfMoved * (members > 1 ? kLongerIfMerged : 1) : 1;
    iterations = static_cast<int>(std::lround(further * longer * std::array{40, 60, 60}[level]));
    plan.coarseIterations = settings.iterations.value_or(iterations) / (moved ? 3 : 6);
    if (moved) {
      plan.start.scaleFactor = kScaleIfMoved;
      plan.start.evenShare = kEvenShareIfMoved;
      plan.rates.quaternion *= kTurnIfMoved;
    }
    // Each scan shows most of the body by itself.
    if (!comparesLosses(settings) && *settings.densifyEvery == 0)
      plan.subsets = std::min(traits.stacks, kMostSubsets);
    if (plan.subsets > 1) {
      plan.rates = plan.rates * kSubsetRates;
      plan.finalRate = kSubsetFinalRate;
    }
  } else {
    // Regions are chosen where there is structure, and a fit of the whole scan is denser there as well: with
    // 1.5 the region is at least within 0.3 dB of that fit (abdominal MR and CT).
    budget = static_cast<std::int64_t>((traits.region ? 1.5 : 1.0) * voxels /
                                       std::array{100.0, 50.0, 16.0}[level]);
    iterations = std::array{60, 200, 400}[level];
    if (addsResidual(settings, traits))
      iterations = thinIterations(std::array{60, 30, 30}[level], iterations, traits);
    plan.coarseIterations = 8;
    if (settings.relocate && *settings.densifyEvery == 0 && settings.initialisation == Initialisation::Grid) {
      plan.relocateEvery = 5;
      plan.relocateShare = 0.05;
      plan.relocateUntil = 0.4;
    }
  }
  if (*settings.paperStopRule) iterations = 1000;
  if (!settings.gaussians) {
    const std::int64_t fewest =
        traits.samples > 0 ? std::min(kFewestGaussians, traits.samples) : kFewestGaussians;
    settings.gaussians = std::clamp<std::int64_t>(budget, fewest, 8'000'000);
    if (settings.maxGaussians) settings.gaussians = std::min(*settings.gaussians, *settings.maxGaussians);
  }
  if (widest > 0)
    plan.bounds.maxLogScale = std::log(
        std::max(2 * traits.voxel, widest * std::cbrt(volume / static_cast<double>(*settings.gaussians))));
  if (!settings.maxGaussians) settings.maxGaussians = settings.gaussians;
  if (!settings.iterations) settings.iterations = iterations;
  if (*settings.paperStopRule) settings.iterations = std::min(*settings.iterations, 1000);
  if (!settings.ensembleSize) settings.ensembleSize = settings.blending == Blending::Normalised ? members : 1;
}

} // namespace

FitPlan makePlan(Settings& settings, const DataTraits& traits) {
  fillChoices(settings, traits);
  FitPlan plan;
  plan.linearIntensity = *settings.linearIntensity;
  plan.loss = {*settings.loss, settings.huberDelta, *settings.ssimWeight, *settings.lossWeight};
  plan.rates = {0.24 * traits.voxel, 0.09, 0.09, 0.15, 0.03, 0.01 / traits.voxel};
  plan.beta1 = *settings.beta1;
  plan.beta2 = *settings.beta2;
  plan.cutoff = *settings.cutoff;
  plan.start.kind = *settings.initialisation;
  plan.start.evenShare *= traits.reached.volume / traits.reached.gaussians;
  plan.bounds.minLogScale = std::log(0.3 * traits.voxel);
  plan.bounds.maxLogScale = std::log(30 * traits.voxel);
  if (settings.blending == Blending::Alpha)
    plan.bounds.maxAbsLogWeight = 4.6; // α ≤ 0.99, as 1 − a is a divisor
  plan.schedule = *settings.schedule;
  plan.plateau = settings.plateau;
  plan.paperStopRule = *settings.paperStopRule;
  plan.allAxes = *settings.allAxes;
  planAmount(settings, traits, plan);
  plan.start.gaussians = *settings.gaussians;
  plan.iterations = *settings.iterations;
  plan.coarseIterations = comparesLosses(settings) ? 0 : std::min(plan.coarseIterations, plan.iterations / 2);
  plan.densify.every = *settings.densifyEvery;
  plan.densify.thresholds = settings.densify;
  plan.densify.limit = *settings.maxGaussians;
  plan.densify.voxel = traits.voxel;
  plan.densify.coverage = plan.allAxes ? 3 : traits.stacks;
  plan.densify.minLogScale = plan.bounds.minLogScale;
  return plan;
}

} // namespace innergs
