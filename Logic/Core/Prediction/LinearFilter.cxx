#include "Core/Prediction/LinearFilter.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr int kStride = PatchFeatures::stride;

struct NormalEquations {
  std::vector<float> square, cross; // [stride][stride], [stride][outputStride]
  std::int64_t samples = 0;
};

/// A X = B for a symmetric positive definite A [n][n]; B [n][m] becomes X.
void solveCholesky(std::vector<double>& a, std::vector<double>& b, int n, int m) {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k)
      a[j * n + j] -= a[j * n + k] * a[j * n + k];
    a[j * n + j] = std::sqrt(a[j * n + j]);
    for (int i = j + 1; i < n; ++i) {
      for (int k = 0; k < j; ++k)
        a[i * n + j] -= a[i * n + k] * a[j * n + k];
      a[i * n + j] /= a[j * n + j];
    }
  }
  for (int q = 0; q < m; ++q) {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k)
        b[i * m + q] -= a[i * n + k] * b[k * m + q];
      b[i * m + q] /= a[i * n + i];
    }
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k < n; ++k)
        b[i * m + q] -= a[k * n + i] * b[k * m + q];
      b[i * m + q] /= a[i * n + i];
    }
  }
}

double keys(double x) { // Keys' cubic convolution, a = -1/2
  x = std::abs(x);
  return x < 1 ? (1.5 * x - 2.5) * x * x + 1 : x < 2 ? ((-0.5 * x + 2.5) * x - 4) * x + 2 : 0;
}

} // namespace

PatchFilter interpolationFilter(const SliceSampling& s, bool cubic) {
  PatchFilter filter{s.phases, 1, {}};
  const int outputs = outputStride(s.phases);
  filter.weights.assign(static_cast<std::size_t>(kStride) * outputs, 0.f);
  for (int q = 0; q < s.phases; ++q) {
    const double x = (s.firstPhase + q - s.centre) / s.phases; // slices after the sample's own
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
  for (const auto* set : {&planes.learning, &planes.measuring})
    for (const TrainingPlane& plane : *set) {
      while (shape.slices > 0 && thinRows(sampling, shape.slices) > plane.rows)
        --shape.slices;
      shape.columns = std::min(shape.columns, plane.columns);
    }
  return shape;
}

Random randomOf(std::uint64_t seed, std::int64_t index) {
  // Random's state moves on by a constant: seeds that differ by multiples of it would share their numbers.
  return Random(Random(seed).next() ^ Random(~static_cast<std::uint64_t>(index)).next());
}

PairPlace randomPlace(const std::vector<TrainingPlane>& planes, const SliceSampling& sampling,
                      const PairShape& shape, Random& random) {
  constexpr int tries = 8;
  constexpr double enough = 0.4; // of a probe of the pair's voxels in the body
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
                        double pairNoise, std::uint64_t seed, const MatrixKernels& kernels,
                        ThreadPool& pool) {
  constexpr std::int64_t pairs = 96;
  constexpr double ridge = 1e-4; // of the mean variance of a patch's samples
  const int outputs = outputStride(sampling.phases);
  const PatchFilter interpolation = interpolationFilter(sampling, true);
  std::vector<NormalEquations> parts(pairs);
  pool.run(pairs, [&](std::int64_t p) {
    Random random = randomOf(seed, p);
    TrainingPair pair;
    const PairPlace place = randomPlace(planes.learning, sampling, shape, random);
    makePair(planes.learning[place.plane], place, sampling, shape.slices, shape.columns, pairNoise, random,
             pair);
    PatchFeatures features;
    makeFeatures(pair.low.data(), pair.slices, pair.columns, 0, features);
    NormalEquations& part = parts[p];
    const std::int64_t samples = features.samples();
    std::vector<float> rest(static_cast<std::size_t>(samples) * outputs, 0.f);
    applyFilter(interpolation, features, kernels, rest.data());
    const int edge = std::min(2, (pair.slices - 1) / 2), side = std::min(4, (pair.columns - 1) / 2);
    for (int s = 0; s < pair.slices; ++s)
      for (int c = -1; c <= pair.columns; ++c) {
        const std::int64_t at = features.at(s, c);
        float* r = rest.data() + at * outputs;
        const std::size_t v = static_cast<std::size_t>(s) * pair.columns + std::max(0, c);
        const bool counts =
            c >= side && c < pair.columns - side && s >= edge && s < pair.slices - edge && pair.inside[v];
        if (!counts) {
          std::fill_n(r, outputs, 0.f);
          std::fill_n(features.values.data() + at * kStride, kStride, 0.f);
          continue;
        }
        ++part.samples;
        for (int q = 0; q < sampling.phases; ++q)
          r[q] = pair.thin[v * sampling.phases + q] - features.mean[at] - r[q];
      }
    part.square.assign(static_cast<std::size_t>(kStride) * kStride, 0.f);
    part.cross.assign(static_cast<std::size_t>(kStride) * outputs, 0.f);
    const float* f = features.values.data();
    kernels.multiplyAdd({kStride, samples, kStride, f, 1, kStride, f, part.square.data()});
    kernels.multiplyAdd({kStride, samples, outputs, f, 1, kStride, rest.data(), part.cross.data()});
  });
  constexpr int n = PatchFeatures::count;
  std::vector<double> square(static_cast<std::size_t>(n) * n, 0.0);
  std::vector<double> cross(static_cast<std::size_t>(n) * sampling.phases, 0.0);
  double samples = 0;
  for (const NormalEquations& part : parts) {
    samples += static_cast<double>(part.samples);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        square[i * n + j] += part.square[i * kStride + j];
      for (int q = 0; q < sampling.phases; ++q)
        cross[i * sampling.phases + q] += part.cross[i * outputs + q];
    }
  }
  double trace = 0;
  for (int i = 0; i < n; ++i)
    trace += square[i * n + i];
  PatchFilter filter = interpolation;
  if (!(trace > 0)) return filter;
  // A prior worth a thousand samples besides, for scans that have few.
  const double weight = trace / n * (ridge + 1e3 * ridge / samples);
  for (int i = 0; i < n; ++i)
    square[i * n + i] += weight;
  solveCholesky(square, cross, n, sampling.phases);
  for (int i = 0; i < n; ++i)
    for (int q = 0; q < sampling.phases; ++q)
      filter.weights[i * outputs + q] += static_cast<float>(cross[i * sampling.phases + q]);
  filter.typical = static_cast<float>(std::sqrt(trace / (n * samples)));
  return filter;
}

void applyFilter(const PatchFilter& filter, const PatchFeatures& features, const MatrixKernels& kernels,
                 float* out) {
  kernels.multiplyAdd({features.samples(), PatchFeatures::count, outputStride(filter.phases),
                       features.values.data(), PatchFeatures::stride, 1, filter.weights.data(), out});
}

} // namespace innergs
