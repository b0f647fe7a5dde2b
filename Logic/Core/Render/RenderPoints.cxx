#include "Core/Render/RenderPoints.h"

#include "Core/Base/Error.h"
#include "Core/Image/Bounds.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/Contribution.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/Kernels.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Gaussians listed by the cells of a coarse grid (cell = 1 index unit of the rendered one) that their
/// ellipsoid's box touches.
struct CellLists {
  std::int64_t size[3];
  std::vector<std::int64_t> start;
  std::vector<std::uint32_t> ids;

  CellLists(std::span<const Projected> gaussians, const std::int64_t (&cells)[3]) {
    std::copy_n(cells, 3, size);
    start.assign(size[0] * size[1] * size[2] + 1, 0);
    for (std::size_t i = 0; i < gaussians.size(); ++i)
      visit(gaussians[i], [&](std::int64_t c) { ++start[c + 1]; });
    for (std::size_t c = 1; c < start.size(); ++c)
      start[c] += start[c - 1];
    ids.resize(start.back());
    std::vector<std::int64_t> cursor(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < gaussians.size(); ++i)
      visit(gaussians[i], [&](std::int64_t c) { ids[cursor[c]++] = static_cast<std::uint32_t>(i); });
  }

  template <class Each>
  void visit(const Projected& g, Each&& each) const {
    std::int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      const double x = g.cell[a] + static_cast<double>(g.fraction[a]);
      low[a] = static_cast<std::int64_t>(std::floor(x - g.half[a]));
      high[a] = static_cast<std::int64_t>(std::floor(x + g.half[a]));
      if (high[a] < 0 || low[a] >= size[a]) return;
      low[a] = std::max<std::int64_t>(low[a], 0);
      high[a] = std::min(high[a], size[a] - 1);
    }
    for (std::int64_t k = low[2]; k <= high[2]; ++k)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t i = low[0]; i <= high[0]; ++i)
          each(i + size[0] * (j + size[1] * k));
  }
};

/// Blends the contributions to one point.
class PointBlend {
public:
  explicit PointBlend(const GaussianField& field)
      : blending_(field.blending), epsilon_(static_cast<float>(field.epsilon)) {}

  void start() {
    w_ = n_ = 0;
    layers_.clear();
  }
  void add(float p, float value, float depth) {
    if (blending_ == Blending::Alpha) layers_.push_back({depth, p, value});
    w_ += p;
    n_ += p * value;
  }
  float value() {
    if (blending_ == Blending::Additive) return n_;
    if (blending_ == Blending::Normalised) return n_ / (w_ + epsilon_);
    std::stable_sort(layers_.begin(), layers_.end(),
                     [](const Layer& a, const Layer& b) { return a.depth < b.depth; });
    float transmittance = 1, image = 0;
    for (const Layer& layer : layers_) {
      image += transmittance * layer.opacity * layer.value;
      transmittance -= transmittance * layer.opacity;
    }
    return image;
  }

private:
  struct Layer {
    float depth, opacity, value;
  };
  Blending blending_;
  float epsilon_, w_ = 0, n_ = 0;
  std::vector<Layer> layers_;
};

bool renderedOnDevice(const RenderOptions& options, std::span<const Vec3> local, float* out) {
  if (!options.device) return false;
  try {
    options.device->renderPoints(local, options.values, out, options.stop);
    return true;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) throw;
  } catch (const std::exception&) {
  }
  return false;
}

} // namespace

std::vector<float> renderPoints(const GaussianField& field, std::span<const Vec3> points,
                                const RenderOptions& options) {
  std::vector<float> result(points.size());
  if (points.empty()) return result;
  if (!options.values.empty() && static_cast<std::int64_t>(options.values.size()) != field.size())
    throw Error(ErrorCode::InvalidArgument, "A channel needs one value per Gaussian.");
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const Affine3 worldToModel = inverse(field.modelToWorld);
  Bounds bounds;
  std::vector<Vec3> local(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    local[i] = worldToModel(points[i]);
    if (!isFinite(local[i])) throw Error(ErrorCode::InvalidArgument, "A query point is not finite.");
    bounds.include(local[i]);
  }
  const FieldValue value(field, {}, {options.values.empty(), options.scannerUnits, options.bounded});
  if (renderedOnDevice(options, local, result.data())) {
    pool.blocks(static_cast<std::int64_t>(points.size()), 1024, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t i = first; i < last; ++i)
        result[i] = value.has(points[i]) ? value(result[i], points[i]) : value.outside();
    });
    return result;
  }
  const double extent = std::max(bounds.longestSide(), 1e-3);
  // About eight cells per point, so that few points do not pay for the lists of a fine grid.
  const double cell = extent / std::clamp(2 * std::cbrt(static_cast<double>(points.size())), 1.0, 64.0);
  SampleGrid grid;
  grid.indexToModel.linear = diagonal({cell, cell, cell});
  grid.indexToModel.offset = bounds.low;
  std::int64_t cells[3];
  for (int a = 0; a < 3; ++a)
    cells[a] = static_cast<std::int64_t>((bounds.high[a] - bounds.low[a]) / cell) + 1;
  std::vector<Projected> projected;
  project(field, options.values, grid, {}, pool, projected);
  const CellLists lists(projected, cells);
  pool.blocks(static_cast<std::int64_t>(points.size()), 1024, [&](std::int64_t first, std::int64_t last) {
    PointBlend blend(field);
    for (std::int64_t i = first; i < last; ++i) {
      if (!value.has(points[i])) {
        result[i] = value.outside();
        continue;
      }
      blend.start();
      Contribution c;
      double x[3];
      std::int64_t at[3];
      for (int a = 0; a < 3; ++a) {
        x[a] = (local[i][a] - bounds.low[a]) / cell;
        at[a] = std::min(static_cast<std::int64_t>(x[a]), cells[a] - 1);
      }
      const std::int64_t own = at[0] + cells[0] * (at[1] + cells[1] * at[2]);
      for (std::int64_t m = lists.start[own]; m < lists.start[own + 1]; ++m) {
        if (contributionAt(projected[lists.ids[m]], x, c)) blend.add(c.p, c.value, c.depth);
      }
      result[i] = value(blend.value(), points[i]);
    }
  });
  return result;
}

} // namespace innergs
