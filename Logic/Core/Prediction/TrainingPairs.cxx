#include "Core/Prediction/TrainingPairs.h"

#include "Core/Image/BodyMask.h"
#include "Core/Prediction/PatchFeatures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr std::int64_t kKeptBack = 6; // every sixth plane

/// Filters a plane along its rows.
void filterRows(TrainingPlane& plane, const LineFilter& filter) {
  if (filter.weights.size() == 1) return;
  std::vector<float> out(plane.values.size(), 0.f);
  for (int r = 0; r < plane.rows; ++r)
    for (std::size_t i = 0; i < filter.weights.size(); ++i) {
      const int from = std::clamp(r + filter.first + static_cast<int>(i), 0, plane.rows - 1);
      const float weight = filter.weights[i];
      const float* in = plane.values.data() + static_cast<std::size_t>(from) * plane.columns;
      float* to = out.data() + static_cast<std::size_t>(r) * plane.columns;
      for (int c = 0; c < plane.columns; ++c)
        to[c] += weight * in[c];
    }
  plane.values = std::move(out);
}

/// Keeps only samples whose patch, blurred and degraded, contains nothing unknown.
void shrinkInside(TrainingPlane& plane, const std::vector<std::uint8_t>& known, int rows, int columns) {
  const auto at = [&](int r, int c) { return static_cast<std::size_t>(r) * plane.columns + c; };
  std::vector<std::uint8_t> near(known.size(), 0);
  for (int r = 0; r < plane.rows; ++r)
    for (int c = 0; c < plane.columns; ++c)
      if (!known[at(r, c)])
        for (int n = std::max(0, c - columns); n <= std::min(plane.columns - 1, c + columns); ++n)
          near[at(r, n)] = 1;
  for (int r = 0; r < plane.rows; ++r)
    for (int c = 0; c < plane.columns; ++c)
      if (near[at(r, c)])
        for (int n = std::max(0, r - rows); n <= std::min(plane.rows - 1, r + rows); ++n)
          plane.inside[at(n, c)] = 0;
}

std::vector<std::uint8_t> resampledNearest(const std::vector<std::uint8_t>& values, int rows, int columns,
                                           const LinePositions& positions, int count) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(count) * columns);
  for (int t = 0; t < count; ++t) {
    const int from =
        std::clamp(static_cast<int>(std::lround(positions.first + positions.step * t)), 0, rows - 1);
    std::copy_n(values.data() + static_cast<std::size_t>(from) * columns, columns,
                out.data() + static_cast<std::size_t>(t) * columns);
  }
  return out;
}

TrainingPlane planeOf(const FilledImage& filled, const std::vector<std::uint8_t>& body, std::int64_t slice,
                      int axis, const SliceSampling& sampling, double sigma) {
  const GridGeometry& g = filled.image.geometry;
  const auto nx = static_cast<int>(g.size[0]), ny = static_cast<int>(g.size[1]);
  TrainingPlane plane;
  plane.rows = axis == 0 ? nx : ny;
  plane.columns = axis == 0 ? ny : nx;
  const std::size_t count = static_cast<std::size_t>(nx) * ny, start = count * slice;
  plane.values.resize(count);
  plane.inside.resize(count);
  std::vector<std::uint8_t> known(filled.known.empty() ? 0 : count);
  for (int r = 0; r < plane.rows; ++r)
    for (int c = 0; c < plane.columns; ++c) {
      const std::size_t to = static_cast<std::size_t>(r) * plane.columns + c;
      const std::size_t from =
          start + (axis == 0 ? static_cast<std::size_t>(c) * nx + r : static_cast<std::size_t>(r) * nx + c);
      plane.values[to] = filled.image.voxels[from];
      plane.inside[to] = body[from];
      if (!known.empty()) known[to] = filled.known[from];
    }
  const LineFilter blur = gaussianFilter(sigma);
  if (!known.empty()) {
    const double perThin = sampling.pitch / g.spacing[axis];
    const double reach = (PatchFeatures::rows / 2 + 1) * sampling.phases +
                         std::max(-sampling.slice.first, sampling.slice.last());
    shrinkInside(plane, known, static_cast<int>(std::ceil(reach * perThin)) + blur.last(),
                 PatchFeatures::width / 2);
  }
  filterRows(plane, blur);
  const double step = sampling.pitch / g.spacing[axis];
  if (std::abs(step - 1) > 0.01) {
    const LinePositions positions{0, step};
    const int rows = static_cast<int>(std::floor((plane.rows - 1) / step + 1e-6)) + 1;
    plane.values = resampledAlong(plane.values.data(), 1, plane.rows, plane.columns, positions, rows);
    plane.inside = resampledNearest(plane.inside, plane.rows, plane.columns, positions, rows);
    plane.rows = rows;
  }
  double inside = 0;
  for (const std::uint8_t v : plane.inside)
    inside += v;
  plane.share = inside / static_cast<double>(plane.inside.size());
  return plane;
}

double gaussian(Random& random) {
  const double radius = std::sqrt(-2 * std::log(random.uniform() + 0x1p-54));
  return radius * std::cos(2 * std::numbers::pi * random.uniform());
}

} // namespace

std::vector<std::uint8_t> knownBody(const FilledImage& filled, const std::stop_token& stop) {
  std::vector<std::uint8_t> body = bodyMask(filled.image, stop);
  if (!filled.known.empty())
    for (std::size_t v = 0; v < body.size(); ++v)
      body[v] &= filled.known[v];
  return body;
}

TrainingPlanes trainingPlanes(const FilledImage& filled, const std::vector<std::uint8_t>& body,
                              const SliceSampling& sampling, const TrainingPlanesRequest& request,
                              ThreadPool& pool) {
  constexpr double leastShare = 0.02; // share of a slice that must lie in the body
  const auto& n = filled.image.geometry.size;
  const std::int64_t area = n[0] * n[1];
  std::vector<std::int64_t> slices;
  for (std::int64_t k = 0; k < n[2]; ++k) {
    std::int64_t inside = 0;
    for (std::int64_t v = k * area; v < (k + 1) * area; ++v)
      inside += body[v];
    if (static_cast<double>(inside) > leastShare * static_cast<double>(area)) slices.push_back(k);
  }
  const std::int64_t axes = request.axes[0] + request.axes[1];
  const std::int64_t most =
      std::max<std::int64_t>(6, request.mostSamples / std::max<std::int64_t>(1, axes * area));
  if (static_cast<std::int64_t>(slices.size()) > most) {
    std::vector<std::int64_t> chosen;
    for (std::int64_t s = 0; s < most; ++s)
      chosen.push_back(slices[static_cast<std::size_t>(
          (2 * s + 1) * static_cast<std::int64_t>(slices.size()) / (2 * most))]);
    slices.swap(chosen);
  }
  const auto chosen = static_cast<std::int64_t>(slices.size());
  std::vector<TrainingPlane> planes(static_cast<std::size_t>(2 * chosen));
  pool.run(2 * chosen, [&](std::int64_t p) {
    const int axis = static_cast<int>(p % 2);
    if (request.axes[axis]) planes[p] = planeOf(filled, body, slices[p / 2], axis, sampling, request.sigma);
  });
  TrainingPlanes result;
  for (std::int64_t p = 0; p < 2 * chosen; ++p)
    if (planes[p].rows > 0)
      (p / 2 % kKeptBack == kKeptBack / 2 && chosen > 1 ? result.measuring : result.learning)
          .push_back(std::move(planes[p]));
  return result;
}

int thinRows(const SliceSampling& s, int slices) {
  const int low = std::min(s.slice.first, s.firstPhase);
  const int high = std::max(s.slice.last(), s.firstPhase + s.phases - 1);
  return (slices - 1) * s.phases + high - low + 1;
}

void makePair(const TrainingPlane& plane, const PairPlace& place, const SliceSampling& s, int slices,
              int columns, double noise, Random& random, TrainingPair& pair) {
  const std::size_t size = static_cast<std::size_t>(slices) * columns;
  pair.slices = slices;
  pair.columns = columns;
  pair.low.assign(size, 0.f);
  pair.thin.resize(size * s.phases);
  pair.inside.assign(size, 1);
  const int low = std::min(s.slice.first, s.firstPhase);
  const int span = thinRows(s, slices);
  // Thin sample t of the pair; rows run backwards in a flipped one.
  const auto rowOf = [&](int t) { return place.row + (place.flipRows ? span - 1 - (t - low) : t - low); };
  const auto columnOf = [&](int c) { return place.column + (place.flipColumns ? columns - 1 - c : c); };
  for (int slice = 0; slice < slices; ++slice) {
    float* out = pair.low.data() + static_cast<std::size_t>(slice) * columns;
    for (std::size_t i = 0; i < s.slice.weights.size(); ++i) {
      const int row = rowOf(slice * s.phases + s.slice.first + static_cast<int>(i));
      const float* in = plane.values.data() + static_cast<std::size_t>(row) * plane.columns;
      const float weight = s.slice.weights[i];
      for (int c = 0; c < columns; ++c)
        out[c] += weight * in[columnOf(c)];
    }
    if (noise > 0)
      for (int c = 0; c < columns; ++c)
        out[c] += static_cast<float>(noise * gaussian(random));
    for (int q = 0; q < s.phases; ++q) {
      const int row = rowOf(slice * s.phases + s.firstPhase + q);
      const std::size_t at = static_cast<std::size_t>(row) * plane.columns;
      float* thin = pair.thin.data() + static_cast<std::size_t>(slice) * columns * s.phases + q;
      std::uint8_t* inside = pair.inside.data() + static_cast<std::size_t>(slice) * columns;
      for (int c = 0; c < columns; ++c) {
        thin[static_cast<std::size_t>(c) * s.phases] = plane.values[at + columnOf(c)];
        inside[c] &= plane.inside[at + columnOf(c)];
      }
    }
  }
}

} // namespace innergs
