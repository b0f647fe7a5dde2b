#include "Core/Prediction/LinearFilter.h"

#include "Core/Base/Cholesky.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr int kStride = PatchFeatures::stride;

struct NormalEquations {
  std::vector<float> square, cross; // [stride][stride], [stride][outputStride]
  std::int64_t samples = 0;
};

/// The normal equations of many pairs.
struct NormalSums {
  static constexpr int n = PatchFeatures::count;
  int phases;
  std::vector<double> square, cross;
  double samples = 0;

  explicit NormalSums(int outputs)
      : phases(outputs), square(static_cast<std::size_t>(n) * n, 0.0),
        cross(static_cast<std::size_t>(n) * outputs, 0.0) {}

  void add(const NormalEquations& part, int outputs) {
    if (part.square.empty()) return;
    samples += static_cast<double>(part.samples);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        square[i * n + j] += part.square[i * kStride + j];
      for (int q = 0; q < phases; ++q)
        cross[i * phases + q] += part.cross[i * outputs + q];
    }
  }

  double trace() const {
    double sum = 0;
    for (int i = 0; i < n; ++i)
      sum += square[i * n + i];
    return sum;
  }
  double meanSquare() const { return samples > 0 ? trace() / (n * samples) : 0; }

  /// Ridge regression towards `prior`.
  std::vector<float> solve(std::vector<float> prior, int outputs) {
    constexpr double ridge = 1e-4, worth = 1e3; // share of the mean variance of a patch's samples; samples
    const double sum = trace();
    if (samples < worth) return prior;
    const double weight = sum / n * ridge * (1 + worth / samples);
    for (int i = 0; i < n; ++i)
      square[i * n + i] += weight;
    solveCholesky(square, cross, n, phases);
    for (int i = 0; i < n; ++i)
      for (int q = 0; q < phases; ++q)
        prior[i * outputs + q] += static_cast<float>(cross[i * phases + q]);
    return prior;
  }
};

double keys(double x) { // Keys' cubic convolution, a = -1/2
  x = std::abs(x);
  return x < 1 ? (1.5 * x - 2.5) * x * x + 1 : x < 2 ? ((-0.5 * x + 2.5) * x - 4) * x + 2 : 0;
}

} // namespace

PatchFilter interpolationFilter(const SliceSampling& s, bool cubic) {
  PatchFilter filter;
  filter.phases = s.phases;
  const int outputs = outputStride(s.phases);
  filter.weights.assign(static_cast<std::size_t>(kStride) * outputs, 0.f);
  for (int q = 0; q < s.phases; ++q) {
    const double x = (s.firstPhase + q - s.centre) / s.phases; // slices from the sample's own
    for (int r = 0; r < PatchFeatures::rows; ++r) {
      const double distance = x - (r - PatchFeatures::rows / 2);
      const double w = cubic ? keys(distance) : std::max(0.0, 1 - std::abs(distance));
      filter.weights[(r * PatchFeatures::width + PatchFeatures::width / 2) * outputs + q] =
          static_cast<float>(w);
    }
  }
  return filter;
}

PairShape pairShape(const TrainingPlanes& planes, const SliceSampling& sampling, std::int64_t stackSlices,
                    PairShape most) {
  PairShape shape{static_cast<int>(std::min<std::int64_t>(stackSlices, most.slices)), most.columns};
  constexpr double part = 0.6; // of a plane: pairs should be able to start and end anywhere in the body
  constexpr int fewest = 8;
  for (const auto* set : {&planes.learning, &planes.measuring})
    for (const TrainingPlane& plane : *set) {
      while (shape.slices > fewest && thinRows(sampling, shape.slices) > part * plane.rows)
        --shape.slices;
      while (shape.slices > 0 && thinRows(sampling, shape.slices) > plane.rows)
        --shape.slices;
      shape.columns = std::min(shape.columns, plane.columns);
    }
  return shape;
}

Random randomOf(std::uint64_t seed, std::int64_t index) {
  // Random's state advances by a constant: seeds that differ by multiples of it would share their numbers.
  return Random(Random(seed).next() ^ Random(~static_cast<std::uint64_t>(index)).next());
}

PairPlace randomPlace(const std::vector<TrainingPlane>& planes, const SliceSampling& sampling,
                      const PairShape& shape, Random& random) {
  constexpr int tries = 8;
  constexpr double enough = 0.4; // share of probed voxels that must lie in the body
  const int span = thinRows(sampling, shape.slices);
  PairPlace place, best;
  double bestShare = -1;
  for (int t = 0; t < tries && bestShare < enough; ++t) {
    const auto below = [&](std::int64_t n) {
      return static_cast<int>(random.next() % static_cast<std::uint64_t>(n));
    };
    place.plane = below(static_cast<std::int64_t>(planes.size()));
    const TrainingPlane& plane = planes[place.plane];
    place.row = below(plane.rows - span + 1);
    place.column = below(plane.columns - shape.columns + 1);
    place.flipRows = below(2);
    place.flipColumns = below(2);
    int hits = 0, probes = 0;
    for (int r = 0; r < span; r += std::max(1, span / 8))
      for (int c = 0; c < shape.columns; c += std::max(1, shape.columns / 8), ++probes)
        hits += plane.inside[static_cast<std::size_t>(place.row + r) * plane.columns + place.column + c];
    const double share = static_cast<double>(hits) / probes;
    if (share > bestShare) {
      bestShare = share;
      best = place;
    }
  }
  return best;
}

PatchFilter learnFilter(const TrainingPlanes& planes, const SliceSampling& sampling, const PairShape& shape,
                        double pairNoise, std::uint64_t seed, const NetworkKernels& kernels,
                        ThreadPool& pool) {
  constexpr std::int64_t pairs = 96;
  constexpr int classes = 2 * PatchFilter::reach + 1; // the last: away from the ends
  const int outputs = outputStride(sampling.phases);
  const PatchFilter interpolation = interpolationFilter(sampling, true);
  std::vector<std::array<NormalEquations, classes>> parts(pairs);
  pool.run(pairs, [&](std::int64_t p) {
    Random random = randomOf(seed, p);
    TrainingPair pair;
    const PairPlace place = randomPlace(planes.learning, sampling, shape, random);
    makePair(planes.learning[place.plane], place, sampling, shape.slices, shape.columns, pairNoise, random,
             pair);
    PatchFeatures features;
    makeFeatures(pair.low.data(), pair.slices, pair.columns, 0, features);
    const std::int64_t samples = features.samples();
    std::vector<float> rest(static_cast<std::size_t>(samples) * outputs, 0.f);
    applyFilter(interpolation, features, kernels, rest.data());
    const int side = std::min(4, (pair.columns - 1) / 2);
    for (int s = 0; s < pair.slices; ++s) {
      const int end = PatchFilter::endOf(s, pair.slices);
      NormalEquations& part = parts[p][end < 0 ? classes - 1 : end];
      for (int c = -1; c <= pair.columns; ++c) {
        const std::int64_t at = features.at(s, c);
        float* r = rest.data() + at * outputs;
        const std::size_t v = static_cast<std::size_t>(s) * pair.columns + std::max(0, c);
        if (c < side || c >= pair.columns - side || !pair.inside[v]) {
          std::fill_n(r, outputs, 0.f);
          std::fill_n(features.values.data() + at * kStride, kStride, 0.f);
          continue;
        }
        ++part.samples;
        for (int q = 0; q < sampling.phases; ++q)
          r[q] = pair.thin[v * sampling.phases + q] - features.mean[at] - r[q];
      }
      part.square.resize(static_cast<std::size_t>(kStride) * kStride, 0.f);
      part.cross.resize(static_cast<std::size_t>(kStride) * outputs, 0.f);
      const std::int64_t width = features.paddedColumns();
      const float* f = features.values.data() + s * width * kStride;
      kernels.multiply({kStride, width, kStride, f, 1, kStride, f, part.square.data()});
      kernels.multiply(
          {kStride, width, outputs, f, 1, kStride, rest.data() + s * width * outputs, part.cross.data()});
    }
  });
  PatchFilter filter = interpolation;
  for (int end = 0; end < classes; ++end) {
    NormalSums sums(sampling.phases);
    for (const auto& part : parts)
      sums.add(part[end], outputs);
    const bool inner = end == classes - 1;
    std::vector<float> weights = sums.solve(interpolation.weights, outputs);
    (inner ? filter.weights : filter.ends[end]) = std::move(weights);
    if (inner && sums.samples > 0) filter.typical = static_cast<float>(std::sqrt(sums.meanSquare()));
  }
  if (parts[0][classes - 1].square.empty()) { // stack too short to have an inside
    filter.weights = interpolation.weights;
    filter.typical = 0;
    NormalSums sums(sampling.phases);
    for (const auto& part : parts)
      for (int end = 0; end < classes - 1; ++end)
        sums.add(part[end], outputs);
    filter.typical = static_cast<float>(std::sqrt(sums.meanSquare()));
  }
  return filter;
}

void applyFilter(const PatchFilter& filter, const PatchFeatures& features, const NetworkKernels& kernels,
                 float* out) {
  const int outputs = outputStride(filter.phases), stack = features.slices - features.before - features.after;
  const auto weightsOf = [&](int slice) -> const std::vector<float>& {
    const int end = PatchFilter::endOf(slice - features.before, stack);
    return end < 0 || filter.ends[end].empty() ? filter.weights : filter.ends[end];
  };
  const std::int64_t width = features.paddedColumns();
  features.forComputed([&](std::int64_t begin, std::int64_t count) {
    for (const std::int64_t end = begin + count; begin < end;) {
      const std::vector<float>& weights = weightsOf(static_cast<int>(begin / width));
      std::int64_t last = std::min(end, (begin / width + 1) * width);
      while (last < end && &weightsOf(static_cast<int>(last / width)) == &weights)
        last = std::min(end, last + width);
      kernels.multiply({last - begin, PatchFeatures::count, outputs, features.values.data() + begin * kStride,
                        kStride, 1, weights.data(), out + begin * outputs});
      begin = last;
    }
  });
}

} // namespace innergs
