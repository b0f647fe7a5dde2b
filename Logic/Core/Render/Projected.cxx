#include "Core/Render/Projected.h"

#include "Core/Render/Rows.h"

#include <algorithm>

namespace innergs {

ProjectionFrame projectionFrame(const SampleGrid& grid) {
  ProjectionFrame f;
  const Affine3 inv = inverse(grid.indexToModel);
  for (int i = 0; i < 3; ++i) {
    f.offset[i] = inv.offset[i];
    for (int j = 0; j < 3; ++j) {
      f.inverse[3 * i + j] = inv.linear[i][j];
      f.toIndex[3 * i + j] = static_cast<float>(inv.linear[i][j]);
      f.toModelT[3 * i + j] = static_cast<float>(grid.indexToModel.linear[j][i]);
    }
  }
  return f;
}

namespace {

constexpr std::int64_t kBlock = 2048; // Gaussians per task

ProjectionRules rulesOf(const GaussianField& field, const ClosedFormPsf& psf, Selection selection) {
  return {static_cast<float>(field.cutoff * field.cutoff), field.blending, field.linearIntensity, selection,
          psf};
}

/// Whether a Gaussian's cut-off ellipsoid may reach planes [low, high] of a frame: its extent along z is at
/// most that of a sphere with the largest scale.
class PlaneReach {
public:
  PlaneReach(const ProjectionFrame& frame, const ProjectionRules& rules, double low, double high)
      : frame_(frame), low_(low), high_(high) {
    const float* t = frame.toIndex + 6;
    const float* c = rules.psf.covariance;
    constexpr double kRounding = 1.001;
    along_ = kRounding * rules.radius2 * (double(t[0]) * t[0] + double(t[1]) * t[1] + double(t[2]) * t[2]);
    // The largest eigenvalue is at most the trace.
    blur_ = rules.psf.active ? static_cast<double>(c[0]) + c[3] + c[5] : 0;
  }

  bool operator()(const Gaussian& g) const {
    double z = frame_.offset[2];
    for (int j = 0; j < 3; ++j)
      z += frame_.inverse[6 + j] * static_cast<double>(g.mean[j]);
    const double beyond = std::max(low_ - z, z - high_);
    return beyond <= 0 || near(beyond, std::exp(std::max({g.logScale[0], g.logScale[1], g.logScale[2]})));
  }

  /// Whether any of a block may.
  bool operator()(const GaussianBlocks::Block& block) const {
    double least = frame_.offset[2], most = least;
    for (int j = 0; j < 3; ++j) {
      const double t = frame_.inverse[6 + j];
      if (t == 0) continue;
      least += t * (t > 0 ? block.low : block.high)[j];
      most += t * (t > 0 ? block.high : block.low)[j];
    }
    const double beyond = std::max(low_ - most, least - high_);
    return beyond <= 0 || near(beyond, block.scale);
  }

private:
  /// False only if a sphere with this scale certainly ends before this many planes; true for NaN.
  bool near(double beyond, double scale) const {
    return !(beyond * beyond > along_ * (scale * scale + blur_) + 1e-4);
  }

  const ProjectionFrame& frame_;
  double low_, high_, along_, blur_;
};

} // namespace

void project(const GaussianField& field, std::span<const float> values, const SampleGrid& grid,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out, Selection selection) {
  const ProjectionFrame frame = projectionFrame(grid);
  const ProjectionRules rules = rulesOf(field, psf, selection);
  out.resize(field.gaussians.size());
  pool.blocks(field.size(), kBlock, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i)
      projectGaussian(field.gaussians[i], values.empty() ? nullptr : &values[i], frame, rules, out[i]);
  });
}

void projectNear(const GaussianField& field, std::span<const float> values, const SampleGrid& grid,
                 const ClosedFormPsf& psf, ThreadPool& pool, NearGaussians& out,
                 const GaussianBlocks* blocks) {
  constexpr std::int64_t kSize = GaussianBlocks::kSize, kBlocksPerTask = kBlock / kSize;
  const ProjectionFrame frame = projectionFrame(grid);
  const ProjectionRules rules = rulesOf(field, psf, Selection::Exact);
  const PlaneReach reaches(frame, rules, grid.z.front(), grid.z.back());
  std::vector<std::int64_t> reached; // blocks of Gaussians
  for (std::int64_t b = 0; b < (field.size() + kSize - 1) / kSize; ++b)
    if (!blocks || reaches(blocks->all()[b])) reached.push_back(b);
  const auto count = static_cast<std::int64_t>(reached.size());
  out.number.resize(static_cast<std::size_t>(count * kSize));
  std::vector<std::int64_t> counts((reached.size() + kBlocksPerTask - 1) / kBlocksPerTask);
  pool.blocks(count, kBlocksPerTask, [&](std::int64_t first, std::int64_t last) {
    std::int64_t at = first * kSize;
    for (std::int64_t n = first; n < last; ++n)
      for (std::int64_t i = reached[n] * kSize; i < std::min(field.size(), (reached[n] + 1) * kSize); ++i)
        if (reaches(field.gaussians[i])) out.number[at++] = static_cast<std::uint32_t>(i);
    counts[first / kBlocksPerTask] = at - first * kSize;
  });
  auto end = out.number.begin();
  for (std::size_t t = 0; t < counts.size(); ++t) {
    const auto from = out.number.begin() + static_cast<std::ptrdiff_t>(t * kBlock);
    end = end == from ? from + counts[t] : std::copy(from, from + counts[t], end);
  }
  out.number.erase(end, out.number.end());
  out.projected.resize(out.number.size());
  pool.blocks(static_cast<std::int64_t>(out.number.size()), kBlock,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t n = first; n < last; ++n) {
                  const std::uint32_t i = out.number[n];
                  projectGaussian(field.gaussians[i], values.empty() ? nullptr : &values[i], frame, rules,
                                  out.projected[n]);
                }
              });
}

float edgeClearance(const Projected& p, const SampleGrid& grid) {
  const float* q = p.quadratic;
  float least = HUGE_VALF;
  for (double z : grid.z) {
    const float dz = planeOffset(p, z);
    if (std::fabs(dz) > p.half[2] + 1) continue;
    for (int y = 0; y < grid.ny; ++y) {
      const float dy = static_cast<float>(y - p.cell[1]) - p.fraction[1];
      if (std::fabs(dy) > p.half[1] + 1) continue;
      const float e0 = q[3] * dy * dy + q[4] * dy * dz + q[5] * dz * dz + p.log2Weight - p.log2Cut;
      for (int x = 0; x < grid.nx; ++x) {
        const float dx = static_cast<float>(x - p.cell[0]) - p.fraction[0];
        least = std::min(least, std::fabs(e0 + dx * (q[0] * dx + q[1] * dy + q[2] * dz)));
      }
    }
  }
  return least;
}

} // namespace innergs
