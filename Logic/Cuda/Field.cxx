#include "Cuda/Field.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Core/Image/Bounds.h"
#include "Core/Render/Projected.h"

#include <algorithm>
#include <cmath>

namespace innergs::cuda {
namespace {

constexpr std::int64_t kMostPoints = std::int64_t{1} << 25, kFewestPoints = std::int64_t{1} << 16;
constexpr std::int64_t kPoints = std::int64_t{1} << 22; // of a query, per batch

GaussianField numbersOf(const GaussianField& field) {
  GaussianField numbers;
  numbers.blending = field.blending;
  numbers.linearIntensity = field.linearIntensity;
  numbers.epsilon = field.epsilon;
  numbers.cutoff = field.cutoff;
  return numbers;
}

} // namespace

Field::Field(std::unique_ptr<Executor> executor, const GaussianField& field)
    : executor_(std::move(executor)), numbers_(numbersOf(field)), count_(field.size()), passes_(*executor_),
      gaussians_(*executor_), values_(*executor_), result_(*executor_), points_(*executor_) {
  gaussians_.upload(field.gaussians.data(), count_);
}

const float* Field::upload(std::span<const float> values) {
  if (values.empty()) return nullptr;
  if (static_cast<std::int64_t>(values.size()) != count_)
    throw Error(ErrorCode::InvalidArgument, "A channel needs one value per Gaussian.");
  values_.upload(values.data(), count_);
  return values_.data();
}

ProjectionRules Field::rules(const ClosedFormPsf& psf) const {
  return {static_cast<float>(numbers_.cutoff * numbers_.cutoff), numbers_.blending, numbers_.linearIntensity,
          Selection::Exact, psf};
}

void Field::renderGrid(const SampleGrid& grid, const ClosedFormPsf& psf, std::span<const float> values,
                       float* out, std::stop_token stop) {
  throwIfStopped(stop);
  if (grid.nx <= 0 || grid.ny <= 0 || grid.z.empty()) return;
  passes_.project(gaussians_.data(), upload(values), count_, projectionFrame(grid), rules(psf));
  const std::int64_t plane = static_cast<std::int64_t>(grid.planeSize()),
                     packed = static_cast<std::int64_t>(grid.nx) * grid.ny;
  std::int64_t points = kMostPoints;
  for (int first = 0; first < grid.planes();) {
    throwIfStopped(stop);
    const int planes = static_cast<int>(std::clamp<std::int64_t>(points / plane, 1, grid.planes() - first));
    try {
      const DevicePlanes slab(*executor_, grid, first, planes);
      passes_.forward(slab, numbers_.blending);
      result_.reserve(packed * planes);
      executor_->runOver(Finish{slab.view(), passes_.planes(), numbers_.blending,
                                static_cast<float>(numbers_.epsilon), result_.data()},
                         packed * planes);
      result_.download(out + packed * first, packed * planes);
      first += planes;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Memory || planes == 1 || points <= kFewestPoints) throw;
      points = std::min(points, plane * planes) / 2;
      passes_.shrink();
      result_.clear();
    }
  }
}

void Field::renderPoints(std::span<const Vec3> points, std::span<const float> values, float* out,
                         std::stop_token stop) {
  throwIfStopped(stop);
  if (points.empty()) return;
  Bounds bounds;
  for (const Vec3& x : points) {
    if (!isFinite(x)) throw Error(ErrorCode::InvalidArgument, "A query point is not finite.");
    bounds.include(x);
  }
  const double extent = std::max(bounds.longestSide(), 1e-3);
  const float* channel = upload(values);
  // Gaussians much larger than a cell are in many lists: if memory is short, the cells get larger.
  for (double cells = std::clamp(2 * std::cbrt(static_cast<double>(points.size())), 1.0, 64.0);; cells /= 2)
    try {
      return answer(points, channel, bounds.low, bounds.high, extent / cells, out, stop);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Memory || cells <= 1) throw;
      passes_.shrink();
    }
}

void Field::answer(std::span<const Vec3> points, const float* channel, const Vec3& low, const Vec3& high,
                   double cell, float* out, const std::stop_token& stop) {
  SampleGrid grid;
  grid.indexToModel.linear = diagonal({cell, cell, cell});
  grid.indexToModel.offset = low;
  int cells[3];
  for (int a = 0; a < 3; ++a)
    cells[a] = static_cast<int>((high[a] - low[a]) / cell) + 1;
  passes_.project(gaussians_.data(), channel, count_, projectionFrame(grid), rules({}));
  std::vector<double> index;
  for (std::size_t first = 0; first < points.size(); first += kPoints) {
    throwIfStopped(stop);
    const std::int64_t n = std::min<std::int64_t>(kPoints, static_cast<std::int64_t>(points.size() - first));
    index.clear();
    for (const Vec3& x : points.subspan(first, n))
      for (int a = 0; a < 3; ++a)
        index.push_back((x[a] - low[a]) / cell);
    points_.upload(index.data(), 3 * n);
    result_.reserve(n);
    passes_.query({cells[0], cells[1], cells[2]}, points_.data(), n, numbers_.blending,
                  static_cast<float>(numbers_.epsilon), result_.data());
    result_.download(out + first, n);
  }
}

} // namespace innergs::cuda
