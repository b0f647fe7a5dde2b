#include "Core/Render/Disagreement.h"

#include "Core/Base/Error.h"
#include "Core/Image/Bounds.h"
#include "Core/Render/Contribution.h"
#include "Core/Render/Projected.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

double position(const Projected& g, int axis) {
  return g.cell[axis] + static_cast<double>(g.fraction[axis]);
}

/// Gaussians listed by the cells (1 index unit each) that their support's box touches.
class Cells {
public:
  Cells(const std::vector<Projected>& gaussians, const std::array<std::int64_t, 3>& size) : size_(size) {
    start_.assign(static_cast<std::size_t>(size[0] * size[1] * size[2]) + 1, 0);
    for (const Projected& g : gaussians)
      visit(g, [&](std::size_t cell) { ++start_[cell + 1]; });
    for (std::size_t c = 1; c < start_.size(); ++c)
      start_[c] += start_[c - 1];
    ids_.resize(start_.back());
    std::vector<std::size_t> cursor(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < gaussians.size(); ++i)
      visit(gaussians[i], [&](std::size_t cell) { ids_[cursor[cell]++] = static_cast<std::uint32_t>(i); });
  }

  std::span<const std::uint32_t> at(const Projected& g) const {
    std::size_t cell = 0, stride = 1;
    for (int a = 0; a < 3; ++a) {
      cell += stride * static_cast<std::size_t>(limited(position(g, a), a));
      stride *= static_cast<std::size_t>(size_[a]);
    }
    return {ids_.data() + start_[cell], start_[cell + 1] - start_[cell]};
  }

private:
  std::int64_t limited(double x, int axis) const {
    return static_cast<std::int64_t>(std::clamp(std::floor(x), 0.0, static_cast<double>(size_[axis] - 1)));
  }
  template <class Each>
  void visit(const Projected& g, Each&& each) const {
    std::int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = limited(position(g, a) - g.half[a], a);
      high[a] = limited(position(g, a) + g.half[a], a);
    }
    for (std::int64_t k = low[2]; k <= high[2]; ++k)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t i = low[0]; i <= high[0]; ++i)
          each(static_cast<std::size_t>(i + size_[0] * (j + size_[1] * k)));
  }

  std::array<std::int64_t, 3> size_;
  std::vector<std::size_t> start_;
  std::vector<std::uint32_t> ids_;
};

} // namespace

std::vector<float> disagreement(const GaussianField& field, int threads, std::stop_token stop) {
  if (field.blending != Blending::Normalised)
    throw Error(ErrorCode::InvalidArgument,
                std::string("Disagreement is defined only for normalised blending; this model's is ") +
                    blendingName(field.blending) + ".");
  std::vector<float> result(field.gaussians.size());
  if (result.empty()) return result;
  ThreadPool pool(threads);
  pool.setStop(std::move(stop));

  // Cells of about twice the mean reach, which keeps both entries per Gaussian and Gaussians per cell few.
  Bounds bounds;
  double reach = 0;
  for (const Gaussian& g : field.gaussians) {
    reach += field.cutoff * std::exp((g.logScale[0] + g.logScale[1] + g.logScale[2]) / 3.0);
    bounds.include({g.mean[0], g.mean[1], g.mean[2]});
  }
  const double extent = std::max(bounds.longestSide(), 1e-3);
  const double cell = std::max(2 * reach / static_cast<double>(result.size()), extent / 256);
  SampleGrid grid;
  grid.indexToModel = {diagonal({cell, cell, cell}), bounds.low};
  std::array<std::int64_t, 3> size;
  for (int a = 0; a < 3; ++a)
    size[a] = static_cast<std::int64_t>((bounds.high[a] - bounds.low[a]) / cell) + 1;
  std::vector<Projected> projected;
  project(field, {}, grid, {}, pool, projected);
  pool.throwIfStopped();
  const Cells cells(projected, size);

  pool.blocks(field.size(), 1024, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const Projected& centre = projected[i];
      const double x[3] = {position(centre, 0), position(centre, 1), position(centre, 2)};
      double w = 0, n = 0, s = 0;
      Contribution c;
      for (const std::uint32_t j : cells.at(centre)) {
        if (!contributionAt(projected[j], x, c)) continue;
        const double p = static_cast<double>(c.p), value = static_cast<double>(c.value);
        w += p;
        n += p * value;
        s += p * value * value;
      }
      if (!(w > 0)) continue;
      const double mean = n / w;
      result[i] =
          static_cast<float>(std::abs(field.intensityScale) * std::sqrt(std::max(0.0, s / w - mean * mean)));
    }
  });
  return result;
}

} // namespace innergs
