#include "Core/Acquisition/BackProjection.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Image/AlignedSampler.h"
#include "Core/Image/WienerFilter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace innergs {
namespace {

// From here on, pixels overlap enough to amplify noise; chosen by measurement (Docs/benchmarks.md).
constexpr double kMostPixels = 1.25;
constexpr std::int64_t kPerTask = 1 << 14; // values
constexpr double kNoiseShare = 0.1;        // of the noise, below which differences are not worth an iteration

struct Residual {
  const Stack* stack;
  std::vector<Affine3> gridToIndex; // one map, or one per posed slice
  std::vector<float> voxels;        // stack − projection; 0 where nothing is known
};

Residual residualOf(const Volume& volume, const Stack& stack, ThreadPool& pool) {
  Residual r{&stack, {}, projectToStack(volume, stack, pool)};
  const Affine3 map = stack.image.geometry.indexToWorld();
  for (const Affine3& pose : stack.poses)
    r.gridToIndex.push_back(inverse(pose * map) * volume.geometry.indexToWorld());
  if (stack.poses.empty()) r.gridToIndex.push_back(inverse(map) * volume.geometry.indexToWorld());
  return r;
}

/// The differences spread along one axis: blocks of `block` values follow each other, n per line.
void spreadAlong(std::vector<float>& differences, const std::vector<double>& weights, std::int64_t n,
                 std::int64_t block, ThreadPool& pool) {
  if (weights.size() == 1) return;
  const auto reach = static_cast<std::int64_t>(weights.size() / 2);
  std::vector<float> out(differences.size(), 0.f);
  const auto blocks = static_cast<std::int64_t>(differences.size()) / block;
  pool.blocks(blocks, std::max<std::int64_t>(1, kPerTask / block),
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t b = first; b < last; ++b) {
                  const std::int64_t at = b % n;
                  for (std::int64_t from = std::max<std::int64_t>(0, at - reach);
                       from <= std::min(n - 1, at + reach); ++from) {
                    const auto w = static_cast<float>(weights[static_cast<std::size_t>(from - at + reach)]);
                    for (std::int64_t p = 0; p < block; ++p)
                      out[b * block + p] += w * differences[(b - at + from) * block + p];
                  }
                }
              });
  differences = std::move(out);
}

/// The differences spread over neighbouring slices and pixels.
void spread(std::vector<float>& differences, const Stack& stack, ThreadPool& pool) {
  const GridGeometry& g = stack.image.geometry;
  spreadAlong(differences, spreadingWeights(stack.profile, effectiveThickness(stack) / g.spacing[2]),
              g.size[2], g.size[0] * g.size[1], pool);
  for (int axis = 0; axis < 2; ++axis)
    spreadAlong(differences, spreadingWeights(stack.profile, stack.pixelWidth / g.spacing[axis], kMostPixels),
                g.size[axis], axis == 0 ? 1 : g.size[0], pool);
}

/// The stack's voxels without the noise in their differences from a projection.
std::vector<float> denoised(const Stack& stack, const std::vector<float>& projection, double noise,
                            ThreadPool& pool) {
  const auto& n = stack.image.geometry.size;
  const std::int64_t plane = n[0] * n[1];
  std::vector<float> out = stack.image.voxels;
  pool.run(n[2], [&](std::int64_t k) {
    std::vector<float> differences(static_cast<std::size_t>(plane));
    const std::int64_t first = k * plane;
    for (std::int64_t p = 0; p < plane; ++p)
      differences[p] = out[first + p] - projection[first + p];
    wienerFilter(differences, n[0], noise);
    for (std::int64_t p = 0; p < plane; ++p)
      if (std::isfinite(differences[p])) out[first + p] = projection[first + p] + differences[p];
  });
  return out;
}

/// Differences from posed slices at the points of one row (j, k) of the volume: of those around a point, each
/// with a tent as wide as the slice distance on either side. Between slices that have moved apart less is
/// known, and less is added.
class PosedRow {
public:
  PosedRow(const Residual& r, std::int64_t points, double j, double k)
      : sums_(static_cast<std::size_t>(points), 0.0), weights_(sums_) {
    GridGeometry slice = r.stack->image.geometry;
    slice.size[2] = 1;
    const auto pixels = static_cast<std::size_t>(slice.size[0] * slice.size[1]);
    for (std::size_t s = 0; s < r.gridToIndex.size(); ++s) {
      const Affine3& map = r.gridToIndex[s];
      const auto distance = [&](const Vec3& at) { // in slice distances
        return dot(map.linear[2], at) + map.offset[2] - static_cast<double>(s);
      };
      const auto [begin, end] = near(distance({0, j, k}), map.linear[2][0], points);
      for (std::int64_t i = begin; i < end; ++i) {
        const Vec3 at{static_cast<double>(i), j, k};
        const double w = 1 - std::abs(distance(at));
        if (w <= 0) continue;
        Vec3 index = map(at);
        index[2] = 0;
        float seen;
        if (!sampleInside(slice, r.voxels.data() + s * pixels, index, seen)) continue;
        sums_[i] += w * seen;
        weights_[i] += w;
      }
    }
  }

  /// Calls add(i, value) wherever enough is known.
  template <class Add>
  void visit(const Add& add) const {
    for (std::size_t i = 0; i < sums_.size(); ++i)
      if (weights_[i] >= 0.1)
        add(static_cast<std::int64_t>(i), static_cast<float>(sums_[i] / std::max(1.0, weights_[i])));
  }

private:
  /// The points [begin, end) of `count` less than 1 from 0, or little more, at first + i·step.
  static std::pair<std::int64_t, std::int64_t> near(double first, double step, std::int64_t count) {
    constexpr double kReach = 1 + 1e-6;
    if (std::abs(step) < 1e-9)
      return {0, std::abs(first) < kReach + 1e-9 * static_cast<double>(count) ? count : 0};
    const auto [low, high] = std::minmax({(-kReach - first) / step, (kReach - first) / step});
    const auto last = static_cast<double>(count);
    return {static_cast<std::int64_t>(std::clamp(std::floor(low), 0.0, last)),
            static_cast<std::int64_t>(std::clamp(std::ceil(high) + 1, 0.0, last))};
  }

  std::vector<double> sums_, weights_;
};

} // namespace

std::vector<double> spreadingWeights(SliceProfile profile, double thickness, double most) {
  if (profile != SliceProfile::Box || thickness <= most + 1e-6) return {1};
  const ProfileQuadrature planes = profileQuadrature(profile, thickness, 1);
  const auto reach = static_cast<std::int64_t>(std::ceil(planes.offset.back()));
  std::vector<double> weights(static_cast<std::size_t>(2 * reach + 1), 0.0);
  for (std::size_t p = 0; p < planes.offset.size(); ++p) { // linearly between the two nearest slices
    const double at = planes.offset[p] + static_cast<double>(reach), low = std::floor(at + 1e-9);
    weights[static_cast<std::size_t>(low)] += planes.weight[p] * (1 - (at - low));
    if (at - low > 1e-9) weights[static_cast<std::size_t>(low) + 1] += planes.weight[p] * (at - low);
  }
  return weights;
}

double backProject(Volume& volume, std::span<const Stack> stacks, const BackProjectionPlan& plan,
                   ThreadPool& pool) {
  const auto& n = volume.geometry.size;
  double rms = 0;
  std::vector<std::vector<float>> wanted; // of each stack; none: its voxels
  for (int iteration = 0; iteration < plan.iterations; ++iteration) {
    std::vector<Residual> residuals;
    double squares = 0, wantedSquares = 0, count = 0;
    for (std::size_t s = 0; s < stacks.size(); ++s) {
      Residual r = residualOf(volume, stacks[s], pool);
      if (iteration == 0 && plan.noise > 0) wanted.push_back(denoised(stacks[s], r.voxels, plan.noise, pool));
      const std::vector<float>& given = stacks[s].image.voxels;
      const std::vector<float>& met = plan.noise > 0 ? wanted[s] : given;
      const std::int64_t slices = stacks[s].image.geometry.size[2], plane = std::ssize(r.voxels) / slices;
      std::vector<std::array<double, 3>> sums(static_cast<std::size_t>(slices));
      pool.run(slices, [&](std::int64_t k) {
        for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v) {
          const float d = met[v] - r.voxels[v], whole = given[v] - r.voxels[v];
          const bool known = std::isfinite(d);
          r.voxels[v] = known ? d : 0;
          sums[k][0] += known ? static_cast<double>(d) * d : 0;
          sums[k][1] += known ? static_cast<double>(whole) * whole : 0;
          sums[k][2] += known;
        }
      });
      for (const auto& [left, all, known] : sums) {
        wantedSquares += left;
        squares += all;
        count += known;
      }
      spread(r.voxels, stacks[s], pool);
      residuals.push_back(std::move(r));
    }
    rms = std::sqrt(squares / std::max(1.0, count));
    if (std::sqrt(wantedSquares / std::max(1.0, count)) <= std::max(plan.stopAt, kNoiseShare * plan.noise))
      break;
    std::vector<std::optional<AlignedSampler>> aligned(residuals.size());
    for (std::size_t s = 0; s < residuals.size(); ++s)
      if (residuals[s].stack->poses.empty())
        aligned[s] =
            AlignedSampler::between(n, residuals[s].gridToIndex.front(), residuals[s].stack->image.geometry);
    pool.run(n[1] * n[2], [&](std::int64_t row) {
      const std::int64_t j = row % n[1], k = row / n[1];
      float* out = volume.voxels.data() + row * n[0];
      const float low = plan.range.low, high = plan.range.high;
      if (residuals.size() == 1 && aligned.front()) { // each point has one difference or none
        aligned.front()->row(residuals.front().voxels.data(), j, k, [=](std::int64_t i, float value) {
          out[i] = std::clamp(out[i] + value, low, high);
        });
        return;
      }
      std::vector<float> sum(static_cast<std::size_t>(n[0]), 0.f), weight = sum;
      const auto add = [sums = sum.data(), weights = weight.data()](std::int64_t i, float value) {
        sums[i] += value;
        weights[i] += 1;
      };
      for (std::size_t s = 0; s < residuals.size(); ++s) {
        const Residual& r = residuals[s];
        if (aligned[s]) {
          aligned[s]->row(r.voxels.data(), j, k, add);
          continue;
        }
        if (!r.stack->poses.empty()) {
          PosedRow(r, n[0], static_cast<double>(j), static_cast<double>(k)).visit(add);
          continue;
        }
        for (std::int64_t i = 0; i < n[0]; ++i) {
          const Vec3 at{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
          float value;
          if (sampleInside(r.stack->image.geometry, r.voxels.data(), r.gridToIndex.front()(at), value))
            add(i, value);
        }
      }
      for (std::int64_t i = 0; i < n[0]; ++i)
        if (weight[i] > 0) out[i] = std::clamp(out[i] + sum[i] / weight[i], low, high);
    });
  }
  return rms;
}

} // namespace innergs
