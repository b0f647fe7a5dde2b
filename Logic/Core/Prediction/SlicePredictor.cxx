#include "Core/Prediction/SlicePredictor.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/NoiseEstimate.h"
#include "Core/Prediction/DetailMask.h"
#include "Core/Prediction/NetworkTraining.h"
#include "Core/Prediction/PlaneApplication.h"
#include "Core/Prediction/PlaneFusion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace innergs {
namespace {

constexpr double kLeastRatio = 1.2, kMostRatio = 12; // slice spacing over in-plane spacing
constexpr std::int64_t kFewestToLearn = 5, kFewestPixelsToLearn = 24;
constexpr std::int64_t kFewestKept = 4; // slices, where every second one is held out
constexpr int kMostPhases = 24;
constexpr double kMatched = 0.05;  // progress before the learning
constexpr double kMostRounds = 40; // passes over a small scan
constexpr int kFewestSteps = 200;
constexpr int kMostSteps = 3000; // of preset balanced
constexpr double kAligned = 1e-3;
constexpr double kUsualDetail = 0.7; // share of the voxels in a DetailMask
// What a pass of a network does per sample beside products, in multiply-adds that take as long.
constexpr double kBesideProducts = 15e3;

double ratioOf(const GridGeometry& stack) {
  return stack.spacing[2] / std::min(stack.spacing[0], stack.spacing[1]);
}

int usualPhases(const GridGeometry& stack) {
  return std::max(2, static_cast<int>(std::lround(std::min(ratioOf(stack), 64.0))));
}

/// The stack's grid with `phases` samples per slice, starting at slice index `first`.
GridGeometry thinGrid(const GridGeometry& stack, double first, int phases, std::int64_t count) {
  GridGeometry thin = stack;
  thin.origin = stack.indexToWorld()({0, 0, first});
  thin.spacing[2] = stack.spacing[2] / phases;
  thin.size[2] = count;
  return thin;
}

double firstSliceOf(const GridGeometry& grid, const GridGeometry& stack) {
  return dot(grid.origin - stack.origin, column(stack.direction, 2)) / stack.spacing[2];
}

void checkGrid(const GridGeometry& grid, const GridGeometry& stack) {
  checkGeometry(grid, "The grid of the prediction");
  const Vec3 shift = grid.origin - stack.origin;
  bool same = grid.size[0] == stack.size[0] && grid.size[1] == stack.size[1];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      same = same && std::abs(grid.direction[a][b] - stack.direction[a][b]) < 1e-4;
  for (int a = 0; a < 2; ++a)
    same = same && std::abs(grid.spacing[a] / stack.spacing[a] - 1) < 1e-4 &&
           std::abs(dot(shift, column(stack.direction, a))) < 0.01 * stack.spacing[a];
  if (!same)
    throw Error(ErrorCode::InvalidArgument,
                "A prediction across slices keeps the stack's pixels: give it a grid that differs from the "
                "stack's only along the slice normal.");
}

/// The grid for learning and predicting, and the requested samples in its indices.
struct ThinGrid {
  GridGeometry geometry;
  int phases = 0;
  LinePositions positions; // K index here of K index there
};

ThinGrid thinGridFor(const GridGeometry& grid, const GridGeometry& stack) {
  const double perSlice = stack.spacing[2] / grid.spacing[2], first = firstSliceOf(grid, stack);
  const int usual = usualPhases(stack);
  ThinGrid thin;
  thin.phases = usual;
  const double whole = std::round(perSlice);
  if (whole >= 1 && std::abs(perSlice - whole) < kAligned) {
    const int times = std::max(1, static_cast<int>(std::lround(usual / whole)));
    if (whole * times <= kMostPhases) {
      thin.phases = std::max(2, static_cast<int>(whole) * times);
      thin.positions.step = thin.phases / whole;
    }
  }
  const bool aligned = std::abs(thin.phases / perSlice - thin.positions.step) < kAligned;
  const double start = aligned ? first : 0.5 / thin.phases - 0.5;
  thin.positions = {(first - start) * thin.phases, thin.phases / perSlice};
  if (aligned) thin.positions = {0, std::round(thin.positions.step)};
  const double last =
      std::max(thin.positions.first, 0.0) + thin.positions.step * static_cast<double>(grid.size[2] - 1);
  const auto count =
      aligned ? static_cast<std::int64_t>(std::llround(last)) + 1 : stack.size[2] * thin.phases;
  thin.geometry = thinGrid(stack, start, thin.phases, count);
  return thin;
}

/// The stack resampled to square pixels of the finer in-plane spacing, unless its pixels are nearly square.
Stack withSquarePixels(const Stack& stack, std::array<bool, 2>& axes, ThreadPool& pool) {
  const GridGeometry& g = stack.image.geometry;
  axes = {true, true};
  const int coarse = g.spacing[0] > g.spacing[1] ? 0 : 1;
  const double ratio = g.spacing[coarse] / g.spacing[1 - coarse];
  if (ratio < 1.1) return stack;
  axes[coarse] = false; // this axis has no detail as fine as the other
  Stack square = stack;
  GridGeometry& s = square.image.geometry;
  s.spacing[coarse] = g.spacing[1 - coarse];
  s.size[coarse] = static_cast<std::int64_t>(std::floor((g.size[coarse] - 1) * ratio + 1e-6)) + 1;
  const LinePositions positions{0, 1 / ratio};
  const std::int64_t outer = coarse == 0 ? g.size[1] * g.size[2] : g.size[2];
  const std::int64_t inner = coarse == 0 ? 1 : g.size[0];
  // Non-finite or unobserved values would spread, so they are marked instead.
  const FilledImage filled = filledImage(stack);
  square.image.voxels = resampledAlong(filled.image.voxels.data(), outer, g.size[coarse], inner, positions,
                                       s.size[coarse], &pool);
  square.observed.clear();
  if (!filled.known.empty()) {
    square.observed.resize(square.image.voxels.size());
    for (std::int64_t o = 0; o < outer; ++o)
      for (std::int64_t t = 0; t < s.size[coarse]; ++t) {
        const double x = static_cast<double>(t) / ratio;
        const auto low = static_cast<std::int64_t>(x);
        const std::int64_t high = std::min(low + 1, g.size[coarse] - 1);
        for (std::int64_t i = 0; i < inner; ++i)
          square.observed[(o * s.size[coarse] + t) * inner + i] =
              filled.known[(o * g.size[coarse] + low) * inner + i] &&
              filled.known[(o * g.size[coarse] + high) * inner + i];
      }
  }
  square.poses.clear();
  square.times.clear();
  return square;
}

/// Resamples the thin samples to the requested grid.
void putOnGrid(const ThinGrid& thin, const GridGeometry& grid, const GridGeometry& stack, Volume image,
               std::vector<std::uint8_t> predicted, Prediction& result, ThreadPool& pool) {
  const bool same = thin.positions.first == 0 && thin.positions.step == 1 && image.geometry.size == grid.size;
  if (!same) {
    const auto& n = image.geometry.size;
    const std::int64_t area = n[0] * n[1], slices = grid.size[2];
    image.voxels = resampledAlong(image.voxels.data(), 1, n[2], area, thin.positions, slices, &pool);
    image.geometry.size[2] = slices;
    if (!predicted.empty()) {
      std::vector<std::uint8_t> there(static_cast<std::size_t>(area * slices));
      for (std::int64_t k = 0; k < slices; ++k) {
        const double x = thin.positions.first + thin.positions.step * static_cast<double>(k);
        const std::int64_t from = std::clamp<std::int64_t>(std::llround(x), 0, n[2] - 1);
        std::copy_n(predicted.begin() + from * area, area, there.begin() + k * area);
      }
      predicted.swap(there);
    }
    if (image.geometry.size != grid.size) {
      const GridGeometry& s = image.geometry;
      const int coarse = s.size[0] != stack.size[0] ? 0 : 1;
      const LinePositions positions{0, stack.spacing[coarse] / s.spacing[coarse]};
      const std::int64_t outer = coarse == 0 ? s.size[1] * slices : slices,
                         inner = coarse == 0 ? 1 : s.size[0];
      image.voxels =
          resampledAlong(image.voxels.data(), outer, s.size[coarse], inner, positions, stack.size[coarse]);
      if (!predicted.empty()) {
        std::vector<std::uint8_t> there(image.voxels.size());
        for (std::int64_t o = 0; o < outer; ++o)
          for (std::int64_t t = 0; t < stack.size[coarse]; ++t) {
            const std::int64_t from = std::min<std::int64_t>(
                std::llround(positions.step * static_cast<double>(t)), s.size[coarse] - 1);
            std::copy_n(predicted.begin() + (o * s.size[coarse] + from) * inner, inner,
                        there.begin() + (o * stack.size[coarse] + t) * inner);
          }
        predicted.swap(there);
      }
    }
  }
  result.image = {grid, std::move(image.voxels)};
  result.predicted = std::move(predicted);
}

/// 1 where an unknown voxel lies within two slices and three pixels; empty: nowhere.
std::vector<std::uint8_t> nearUnknown(const FilledImage& filled, ThreadPool& pool) {
  std::vector<std::uint8_t> near(filled.known.size());
  for (std::size_t v = 0; v < near.size(); ++v)
    near[v] = !filled.known[v];
  if (!near.empty()) dilate(near, filled.image.geometry.size, {3, 3, 2}, pool);
  return near;
}

/// Interpolates next to unwanted voxels, restores acquired thin slices, and clamps to the observed range.
/// Returns which voxels are predicted; empty: all.
std::vector<std::uint8_t> finish(const FilledImage& filled, const std::vector<std::uint8_t>& wanted,
                                 const SliceSampling& sampling, Volume& thin, ThreadPool& pool) {
  const auto& n = filled.image.geometry.size;
  const std::int64_t area = n[0] * n[1];
  float low = filled.image.voxels[0], high = low; // filled voxels repeat known ones
  for (const float v : filled.image.voxels) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  std::vector<std::uint8_t> predicted;
  if (std::find(wanted.begin(), wanted.end(), 0) != wanted.end()) predicted.assign(thin.voxels.size(), 1);
  const bool acquired = sampling.slice.weights.size() == 1;
  pool.run(thin.geometry.size[2], [&](std::int64_t t) {
    const double slice = (static_cast<double>(t) - sampling.centre) / sampling.phases;
    const double inside = std::clamp(slice, 0.0, static_cast<double>(n[2] - 1));
    const auto below = static_cast<std::int64_t>(inside);
    const std::int64_t above = std::min(below + 1, n[2] - 1);
    const auto share = static_cast<float>(inside - static_cast<double>(below));
    const auto nearest = static_cast<std::int64_t>(std::lround(inside));
    const bool onSlice = acquired && std::abs(slice - static_cast<double>(nearest)) < 1e-4;
    float* out = thin.voxels.data() + t * area;
    for (std::int64_t p = 0; p < area; ++p) {
      const float a = filled.image.voxels[below * area + p], b = filled.image.voxels[above * area + p];
      if (!wanted[below * area + p] || !wanted[above * area + p]) {
        out[p] = a + share * (b - a);
        predicted[t * area + p] = 0;
      } else if (onSlice) {
        out[p] = filled.image.voxels[nearest * area + p];
      }
      out[p] = std::clamp(out[p], low, high);
    }
  });
  return predicted;
}

struct Effort {
  TrainingPlan training;
  Reflections reflections = Reflections::Two;
};

Effort effortOf(PredictionEffort effort, double muchToLearn) {
  Effort e;
  TrainingPlan& plan = e.training;
  if (effort == PredictionEffort::Brief || effort == PredictionEffort::Fast) {
    plan.channels = 16;
    plan.steps = effort == PredictionEffort::Brief ? 400 : 500;
    if (effort == PredictionEffort::Brief) e.reflections = Reflections::None;
  } else if (effort == PredictionEffort::Balanced && muchToLearn > 0) {
    plan.steps = static_cast<int>(std::lround(plan.steps + muchToLearn * (kMostSteps - plan.steps)));
    plan.rate = 4e-3;
  } else if (effort == PredictionEffort::Best) {
    plan.channels = 64;
    plan.steps = 10000;
    e.reflections = Reflections::Four;
  }
  return e;
}

/// The efforts of the networks that are trained, of which the better one is used.
std::vector<PredictionEffort> levelsOf(PredictionEffort effort) {
  if (effort == PredictionEffort::Filter) return {};
  if (effort == PredictionEffort::Best) return {PredictionEffort::Balanced, effort};
  return {effort};
}

/// Of one network.
PredictionOperations operationsOf(PredictionEffort level, const GridGeometry& stack,
                                  const PredictionOptions& options) {
  const Effort effort = effortOf(level, options.muchToLearn);
  const TrainingPlan& plan = effort.training;
  const int phases = thinGridFor(options.grid.value_or(predictionGrid(stack)), stack).phases;
  const double pass =
      ConvolutionNetwork::productsPerSample({phases, plan.channels, plan.layers}) + kBesideProducts;
  const auto voxels = static_cast<double>(stack.voxelCount());
  const auto samples = static_cast<double>(std::min<std::int64_t>(plan.most.slices, stack.size[2]) *
                                           std::min<std::int64_t>(plan.most.columns, stack.size[0]));
  const double rounds = kMostRounds * 2 * voxels / (plan.pairs * samples * phases);
  const double steps = std::clamp(rounds, double{kFewestSteps}, static_cast<double>(plan.steps));
  const double reflections = effort.reflections == Reflections::None  ? 1
                             : effort.reflections == Reflections::Two ? 2
                                                                      : 4;
  return {3 * steps * plan.pairs * samples * pass, // forward, and backward twice
          2 * reflections * kUsualDetail * voxels * pass};
}

/// Errors on the held-out planes.
PairErrors measure(const SliceModel& model, const TrainingPlanes& planes, const PairShape& shape,
                   double pairNoise, std::uint64_t seed, const NetworkKernels& kernels, ThreadPool& pool) {
  constexpr std::int64_t pairs = 48;
  const int phases = model.sampling.phases, outputs = outputStride(phases);
  const PatchFilter linear = interpolationFilter(model.sampling, false),
                    cubic = interpolationFilter(model.sampling, true);
  std::vector<PairErrors> parts(pairs); // sums of squares
  pool.run(pairs, [&](std::int64_t p) {
    PairErrors& part = parts[p];
    Random random = randomOf(seed + 2, p);
    const PairPlace place = randomPlace(planes.measuring, model.sampling, shape, random);
    TrainingPair pair;
    makePair(planes.measuring[place.plane], place, model.sampling, shape.slices, shape.columns, pairNoise,
             random, pair);
    PatchFeatures features;
    makeFeatures(pair.low.data(), pair.slices, pair.columns, model.floor, features);
    ConvolutionNetwork::Workspace work;
    std::vector<float> network;
    predictSamples(model, features, kernels, work, network);
    const auto filtered = [&](const PatchFilter& filter) {
      std::vector<float> out(network.size(), 0.f);
      applyFilter(filter, features, kernels, out.data());
      return out;
    };
    const std::vector<float> byLinear = filtered(linear), byCubic = filtered(cubic),
                             byFilter = filtered(model.filter);
    const int side = pair.columns > 16 ? 4 : 0;
    for (int s = 0; s < pair.slices; ++s)
      for (int c = side; c < pair.columns - side; ++c) {
        const std::size_t v = static_cast<std::size_t>(s) * pair.columns + c;
        if (!pair.inside[v]) continue;
        const std::int64_t at = features.at(s, c);
        for (int q = 0; q < phases; ++q) {
          const double truth = pair.thin[v * phases + q];
          const auto squared = [&](const std::vector<float>& by) {
            const double e = features.mean[at] + features.deviation[at] * by[at * outputs + q] - truth;
            return e * e;
          };
          part.linear += squared(byLinear);
          part.cubic += squared(byCubic);
          part.filter += squared(byFilter);
          part.network += squared(network);
        }
        part.samples += phases;
      }
  });
  PairErrors e;
  for (const PairErrors& part : parts) {
    e.samples += part.samples;
    e.linear += part.linear;
    e.cubic += part.cubic;
    e.filter += part.filter;
    e.network += part.network;
  }
  for (double* sum : {&e.linear, &e.cubic, &e.filter, &e.network})
    *sum = std::sqrt(*sum / static_cast<double>(std::max<std::int64_t>(1, e.samples)));
  return e;
}

std::string gainText(const PairErrors& e) {
  const double gain = 20 * std::log10(std::min(e.linear, e.cubic) / e.network);
  return formatted("%.1f dB", gain);
}

} // namespace

const char* predictionPhaseName(PredictionPhase phase) {
  return phase == PredictionPhase::Matching   ? "matching"
         : phase == PredictionPhase::Learning ? "learning"
                                              : "applying";
}

GridGeometry predictionGrid(const GridGeometry& stack) {
  const int phases = usualPhases(stack);
  return thinGrid(stack, 0.5 / phases - 0.5, phases, stack.size[2] * phases);
}

PredictionOperations predictionOperations(const GridGeometry& stack, const PredictionOptions& options) {
  PredictionOperations all;
  for (const PredictionEffort level : levelsOf(options.effort)) {
    const PredictionOperations one = operationsOf(level, stack, options);
    all.learning += one.learning;
    all.applying = one.applying;
  }
  return all;
}

Prediction predictAcrossSlices(const Stack& given, const PredictionOptions& options, ThreadPool& pool,
                               const PredictionCallback& progress) {
  checkStack(given);
  const GridGeometry& g = given.image.geometry;
  const GridGeometry grid = options.grid.value_or(predictionGrid(g));
  checkGrid(grid, g);
  const NetworkKernels& kernels = networkKernels(options.instructionSet);
  const auto start = std::chrono::steady_clock::now();
  const auto report = [&](PredictionPhase phase, double fraction) {
    if (progress) progress({phase, fraction});
  };
  Prediction result;
  const auto nothing = [&](const std::string& why) {
    result.sentence = "Nothing was learned across the slices: " + why;
    result.learningSeconds = secondsSince(start);
    return result;
  };
  report(PredictionPhase::Matching, 0);
  const double ratio = ratioOf(g), ofScan = options.everySecond ? ratio / 2 : ratio;
  if (ratio < kLeastRatio) return nothing("they lie as close as the pixels.");
  if (ofScan > kMostRatio + kAligned)
    return nothing(
        formatted("they lie %.3g pixels apart, and more than %.0f are too many.", ofScan, kMostRatio));
  if (options.everySecond && g.size[2] < kFewestKept)
    return nothing("they are too few for every second one to be held out.");
  if (!options.everySecond && g.size[2] < kFewestToLearn)
    return nothing(formatted("%d slices are too few.", static_cast<int>(g.size[2])));
  if (std::min(g.size[0], g.size[1]) < std::max<std::int64_t>(kFewestPixelsToLearn, std::llround(5 * ratio)))
    return nothing("they have too few pixels.");

  std::array<bool, 2> axes;
  const Stack stack = withSquarePixels(given, axes, pool);
  const GridGeometry& working = stack.image.geometry;
  GridGeometry workingGrid = grid;
  for (int a = 0; a < 2; ++a) {
    workingGrid.size[a] = working.size[a];
    workingGrid.spacing[a] = working.spacing[a];
  }
  const ThinGrid thin = thinGridFor(workingGrid, working);
  SliceModel model;
  model.sampling = sliceSampling(stack, thin.geometry, thin.phases);
  const FilledImage filled = filledImage(stack);
  pool.throwIfStopped();
  std::vector<std::uint8_t> body = knownBody(filled, pool.stopToken());
  const double noise = estimateFineDetail(filled.image, body);
  if (!(noise > 0)) return nothing("the image is constant, or one of labels.");
  pool.throwIfStopped();

  TrainingPlanesRequest request;
  request.axes = axes;
  request.sigma = options.matchingBlur;
  // Restores the noise that blurring and degrading removed from the pairs but that the slices still have.
  const double perThin = std::min(working.spacing[0], working.spacing[1]) / model.sampling.pitch;
  double squares = 0;
  for (const float w :
       convolved(gaussianFilter(options.matchingBlur * perThin), model.sampling.slice).weights)
    squares += static_cast<double>(w) * w;
  const double pairNoise = noise * std::sqrt(std::max(0.0, 1 - squares));
  const TrainingPlanes planes = trainingPlanes(filled, body, model.sampling, request, pool);
  const Effort effort = effortOf(options.effort, options.muchToLearn);
  const PairShape shape = pairShape(planes, model.sampling, working.size[2], effort.training.most);
  if (planes.learning.empty() || planes.measuring.empty() || shape.slices < 4)
    return nothing("too little of the image can be learned from.");
  double thinSamples = 0;
  for (const TrainingPlane& plane : planes.learning)
    thinSamples += static_cast<double>(plane.values.size());
  const double perStep =
      static_cast<double>(effort.training.pairs) * shape.slices * shape.columns * thin.phases;
  report(PredictionPhase::Learning, kMatched);
  model.filter = learnFilter(planes, model.sampling, shape, pairNoise, options.seed, kernels, pool);
  model.floor = static_cast<float>(std::max(0.05 * model.filter.typical, noise));
  const TrainingSource source{planes, model.sampling, model.filter, shape, model.floor, pairNoise};
  const auto measureModel = [&](const SliceModel& m) {
    return measure(m, planes, shape, pairNoise, options.seed, kernels, pool);
  };
  const PredictionOperations work = predictionOperations(g, options).perThread(pool.threads());
  double learned = kMatched; // the progress
  std::optional<PairErrors> best;
  // A large network may learn the noise of a small scan, so it must be better than a smaller one.
  for (const PredictionEffort level : levelsOf(options.effort)) {
    TrainingPlan plan = effortOf(level, options.muchToLearn).training;
    plan.fromScratch = options.fromScratch;
    plan.steps =
        std::min(plan.steps, std::max(kFewestSteps, static_cast<int>(kMostRounds * thinSamples / perStep)));
    const double part = (1 - kMatched) * operationsOf(level, g, options).perThread(pool.threads()).learning /
                        (work.learning + work.applying);
    SliceModel trained = model;
    trained.network = trainNetwork({&source, 1}, plan, options.seed, kernels, pool,
                                   [&](double f) { report(PredictionPhase::Learning, learned + part * f); });
    trained.transforms = trained.network->transforms();
    learned += part;
    const PairErrors found = measureModel(trained);
    if (found.network > (best ? best->network : found.filter)) continue;
    model = std::move(trained);
    best = found;
  }
  result.pairs = best ? *best : measureModel(model);
  if (result.pairs.samples == 0) return nothing("too little of the image can be learned from.");
  result.phases = thin.phases;
  result.learningSeconds = secondsSince(start);

  const auto applying = std::chrono::steady_clock::now();
  std::vector<std::uint8_t> wanted = detailMask(filled, std::move(body), noise, pool);
  const std::vector<std::uint8_t> near = nearUnknown(filled, pool);
  for (std::size_t v = 0; v < near.size(); ++v)
    wanted[v] &= !near[v];
  const std::array<std::vector<float>, 2> both =
      applyAcrossSlices(model, filled.image, wanted, effort.reflections, kernels, thin.geometry, pool,
                        [&](double f) { report(PredictionPhase::Applying, learned + (1 - learned) * f); });
  const auto complete = [&](std::vector<float> voxels) {
    Volume image{thin.geometry, std::move(voxels)};
    std::vector<std::uint8_t> predicted = finish(filled, wanted, model.sampling, image, pool);
    putOnGrid(thin, grid, g, std::move(image), std::move(predicted), result, pool);
  };
  if (!options.fused || options.everySecond) {
    std::vector<float> mean = both[0];
    for (std::size_t v = 0; v < mean.size(); ++v)
      mean[v] = 0.5f * (mean[v] + both[1][v]);
    complete(std::move(mean));
  }
  if (options.fused) {
    result.mean = std::move(result.image);
    complete(fusedPlanes(both, thin.geometry.size, pool));
  }
  pool.throwIfStopped();
  result.learned = true;
  result.sentence = "Learned across the slices from the images along them: " + gainText(result.pairs) +
                    " better than interpolation on held-out ones.";
  result.applyingSeconds = secondsSince(applying);
  return result;
}

} // namespace innergs
