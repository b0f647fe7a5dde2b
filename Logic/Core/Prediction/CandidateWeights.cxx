#include "Core/Prediction/CandidateWeights.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Base/Error.h"
#include "Core/Image/FilledImage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr double kOnSlice = 1e-6;         // slice distances: within this, a position is the slice itself
constexpr double kNegligible = 1e-7;      // smaller weights are dropped
constexpr std::int64_t kSplineReach = 14; // slices: the spline's weights fall by a factor of 0.27 per slice
constexpr std::int64_t kPiece = 2048;     // samples of a plane per task

struct Position {
  std::int64_t base;
  double fraction;
};

Position positionAt(double position, std::int64_t slices) {
  double p = std::clamp(position, 0.0, static_cast<double>(slices - 1));
  if (std::abs(p - std::round(p)) < kOnSlice) p = std::round(p);
  const auto base = static_cast<std::int64_t>(std::floor(p));
  return {base, p - static_cast<double>(base)};
}

/// Adds the weights of the samples in the coefficient of a cubic B-spline at `at` (mirrored borders): a row
/// of the inverse of the tridiagonal (1 4 1)/6, a sum of decaying powers over the mirrored samples.
void addCoefficient(std::int64_t at, std::int64_t slices, double share, std::vector<double>& row) {
  const auto mirrored = [&](std::int64_t i) {
    if (slices == 1) return std::int64_t{0};
    const std::int64_t period = 2 * (slices - 1);
    i = ((i % period) + period) % period;
    return i < slices ? i : period - i;
  };
  const double pole = std::sqrt(3.0) - 2;
  double power = std::sqrt(3.0); // −6·pole/(1 − pole²)
  row[mirrored(at)] += share * power;
  for (std::int64_t n = 1; n <= 2 * kSplineReach; ++n) {
    power *= pole;
    row[mirrored(at - n)] += share * power;
    row[mirrored(at + n)] += share * power;
  }
}

void addLanczos(const Position& p, std::int64_t slices, double share, std::vector<double>& row) {
  const auto sinc = [](double x) {
    return std::abs(x) < 1e-12 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
  };
  double weights[8], sum = 0;
  for (int t = 0; t < 8; ++t) {
    const double x = p.fraction - (t - 3);
    weights[t] = std::abs(x) < 4 ? sinc(x) * sinc(x / 4) : 0;
    sum += weights[t];
  }
  for (int t = 0; t < 8; ++t)
    row[std::clamp<std::int64_t>(p.base + t - 3, 0, slices - 1)] += share * weights[t] / sum;
}

void addWeights(Candidate candidate, const Kriging& kriging, const Position& p, std::int64_t slices,
                double share, std::vector<double>& row) {
  if (candidate == Candidate::Kriging) {
    kriging.addWeights(static_cast<double>(p.base) + p.fraction, share, row);
    return;
  }
  if (p.fraction == 0) {
    row[p.base] += share;
    return;
  }
  const double f = p.fraction, g = 1 - f;
  switch (candidate) {
  case Candidate::Linear:
    row[p.base] += share * g;
    row[p.base + 1] += share * f;
    return;
  case Candidate::Cubic: {
    const double spline[4] = {g * g * g / 6, 2.0 / 3 - f * f + f * f * f / 2, 2.0 / 3 - g * g + g * g * g / 2,
                              f * f * f / 6};
    for (int t = 0; t < 4; ++t)
      addCoefficient(p.base + t - 1, slices, share * spline[t], row);
    return;
  }
  case Candidate::Lanczos:
    addLanczos(p, slices, share, row);
    return;
  case Candidate::Kriging:
    return;
  }
}

} // namespace

const char* candidateName(Candidate candidate) {
  constexpr const char* names[] = {"linear", "cubic", "Lanczos", "kriging"};
  return names[static_cast<int>(candidate)];
}

Kriging krigingOf(const Stack& stack, double blur) {
  const double distance = stack.image.geometry.spacing[2];
  return {blur / distance, stack.profile, effectiveThickness(stack) / distance};
}

SliceWeights combinedWeights(const std::array<double, kCandidates>& share, const Kriging& kriging,
                             std::int64_t slices, std::span<const double> positions) {
  SliceWeights result;
  std::vector<double> row(static_cast<std::size_t>(slices));
  for (const double position : positions) {
    std::fill(row.begin(), row.end(), 0.0);
    const Position p = positionAt(position, slices);
    for (int c = 0; c < kCandidates; ++c)
      if (share[c] != 0) addWeights(static_cast<Candidate>(c), kriging, p, slices, share[c], row);
    std::int64_t first = 0, last = slices - 1;
    while (first < last && std::abs(row[first]) < kNegligible)
      ++first;
    while (last > first && std::abs(row[last]) < kNegligible)
      --last;
    result.first.push_back(first);
    result.weight.emplace_back(row.begin() + first, row.begin() + last + 1);
  }
  return result;
}

SliceWeights candidateWeights(Candidate candidate, const Kriging& kriging, std::int64_t slices,
                              std::span<const double> positions) {
  std::array<double, kCandidates> share{};
  share[static_cast<std::size_t>(candidate)] = 1;
  return combinedWeights(share, kriging, slices, positions);
}

void applyWeights(const SliceWeights& weights, std::span<const float> slices, std::int64_t samples,
                  std::span<float> planes, ThreadPool& pool) {
  const auto count = static_cast<std::int64_t>(weights.first.size());
  const std::int64_t pieces = (samples + kPiece - 1) / kPiece;
  pool.run(pieces, [&](std::int64_t piece) { // all planes of a piece, so that its slices stay in the cache
    const std::int64_t begin = piece * kPiece, width = std::min(kPiece, samples - begin);
    for (std::int64_t z = 0; z < count; ++z) {
      float* out = planes.data() + z * samples + begin;
      const float* in = slices.data() + weights.first[z] * samples + begin;
      const auto& row = weights.weight[z];
      for (std::int64_t i = 0; i < width; ++i)
        out[i] = row[0] * in[i];
      for (std::size_t t = 1; t < row.size(); ++t) {
        in += samples;
        const float w = row[t];
        for (std::int64_t i = 0; i < width; ++i)
          out[i] += w * in[i];
      }
    }
  });
}

std::vector<double> planePositions(const GridGeometry& stack, const GridGeometry& grid) {
  const Affine3 map = inverse(stack.indexToWorld()) * grid.indexToWorld();
  bool same = stack.size[0] == grid.size[0] && stack.size[1] == grid.size[1];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      if (a != 2 || b != 2)
        same =
            same && std::abs(map.linear[a][b] - (a == b ? 1 : 0)) * static_cast<double>(grid.size[b]) < 1e-3;
  same = same && std::abs(map.offset[0]) < 1e-3 && std::abs(map.offset[1]) < 1e-3 && map.linear[2][2] > 0;
  if (!same)
    throw Error(ErrorCode::InvalidArgument,
                "A prediction between slices needs a grid that matches theirs in-plane.");
  std::vector<double> positions;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    positions.push_back(map.offset[2] + map.linear[2][2] * static_cast<double>(k));
  return positions;
}

namespace {

/// Evaluates the natural cubic spline through (at[i], value[i]) at every integer from the first to the last.
void fillColumn(const std::vector<std::int64_t>& at, std::vector<double>& value, std::vector<double>& scratch,
                std::vector<float>& column) {
  const std::size_t n = at.size();
  std::vector<double>& curvature = scratch;
  curvature.assign(2 * n, 0.0);
  double* m = curvature.data();
  double* c = m + n;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const auto before = static_cast<double>(at[i] - at[i - 1]),
               after = static_cast<double>(at[i + 1] - at[i]);
    const double right = 6 * ((value[i + 1] - value[i]) / after - (value[i] - value[i - 1]) / before);
    const double pivot = 2 * (before + after) - before * c[i - 1];
    c[i] = after / pivot;
    m[i] = (right - before * m[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;)
    m[i] -= c[i] * m[i + 1];
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const auto h = static_cast<double>(at[i + 1] - at[i]);
    for (std::int64_t k = at[i] + 1; k < at[i + 1]; ++k) {
      const double b = static_cast<double>(k - at[i]) / h, a = 1 - b;
      column[k] = static_cast<float>(a * value[i] + b * value[i + 1] +
                                     ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]) * h * h / 6);
    }
  }
}

} // namespace

std::vector<float> completeSlices(const Stack& stack, ThreadPool& pool) {
  const auto& size = stack.image.geometry.size;
  const std::int64_t plane = size[0] * size[1];
  std::vector<float> voxels = stack.image.voxels;
  const auto known = [&](std::int64_t v) { return isKnown(stack, v); };
  std::vector<std::uint8_t> empty(static_cast<std::size_t>(plane), 0); // columns without known voxels
  pool.blocks(plane, 256, [&](std::int64_t from, std::int64_t to) {
    std::vector<std::int64_t> at;
    std::vector<double> value, scratch;
    std::vector<float> column(static_cast<std::size_t>(size[2]));
    for (std::int64_t p = from; p < to; ++p) {
      at.clear();
      value.clear();
      for (std::int64_t k = 0; k < size[2]; ++k)
        if (known(k * plane + p)) {
          at.push_back(k);
          value.push_back(column[k] = voxels[k * plane + p]);
        }
      if (static_cast<std::int64_t>(at.size()) == size[2]) continue;
      empty[p] = at.empty();
      if (at.empty()) continue;
      fillColumn(at, value, scratch, column);
      std::fill(column.begin(), column.begin() + at.front(), static_cast<float>(value.front()));
      std::fill(column.begin() + at.back() + 1, column.end(), static_cast<float>(value.back()));
      for (std::int64_t k = 0; k < size[2]; ++k)
        voxels[k * plane + p] = column[k];
    }
  });
  if (std::find(empty.begin(), empty.end(), 1) == empty.end()) return voxels;
  Stack columns;
  columns.image = {stack.image.geometry, std::move(voxels)};
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (const std::uint8_t none : empty)
      columns.observed.push_back(!none);
  return filledImage(columns, pool.stopToken()).image.voxels;
}

} // namespace innergs
