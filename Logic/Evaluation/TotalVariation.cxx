#include "Evaluation/TotalVariation.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Base/Error.h"
#include "Evaluation/Baselines.h"
#include "Evaluation/SeparableResample.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

struct Tap {
  std::int64_t index;
  float weight;
};

/// The slices of one stack as weighted sums of voxels along a grid axis.
struct BlurOperator {
  std::array<std::int64_t, 3> stride{}, start{}; // steps of the stack's samples per grid index, in-plane axes
  int axis = 2;                                  // grid axis normal to the slices
  std::int64_t sliceStride = 1;
  std::vector<std::vector<Tap>> voxels; // per slice
  std::vector<std::vector<Tap>> slices; // per grid index along axis
  std::vector<float> target, dual;      // per sample; target NaN: unknown

  std::int64_t sample(const std::array<std::int64_t, 3>& at, std::int64_t slice) const {
    std::int64_t index = slice * sliceStride;
    for (int a = 0; a < 3; ++a)
      if (a != axis) index += start[a] + stride[a] * at[a];
    return index;
  }
};

BlurOperator makeOperator(const Stack& stack, const GridGeometry& grid, double scale) {
  const GridGeometry& g = stack.image.geometry;
  const auto map = alignedAxes(g, grid);
  const auto refuse = [] {
    throw Error(ErrorCode::InvalidArgument, "Total variation needs stacks whose pixels are the grid's.");
  };
  if (!map || !stack.poses.empty()) refuse();
  BlurOperator op;
  const std::int64_t strides[3] = {1, g.size[0], g.size[0] * g.size[1]};
  for (int a = 0; a < 3; ++a) {
    if (map->axis[a] == 2) {
      op.axis = a;
      continue;
    }
    const double first = std::round(map->offset[a]), step = std::round(map->scale[a]);
    if (std::abs(step) != 1 || std::abs(map->offset[a] - first) > 1e-3 ||
        std::abs(map->scale[a] - step) * static_cast<double>(grid.size[a]) > 1e-3 ||
        g.size[map->axis[a]] != grid.size[a])
      refuse();
    op.start[a] = static_cast<std::int64_t>(first) * strides[map->axis[a]];
    op.stride[a] = static_cast<std::int64_t>(step) * strides[map->axis[a]];
  }
  op.sliceStride = strides[2];
  const std::int64_t length = grid.size[op.axis];
  const double spacing = grid.spacing[op.axis];
  const ProfileQuadrature profile = profileQuadrature(stack.profile, effectiveThickness(stack), spacing);
  op.voxels.resize(static_cast<std::size_t>(g.size[2]));
  op.slices.resize(static_cast<std::size_t>(length));
  for (std::int64_t s = 0; s < g.size[2]; ++s) {
    std::vector<double> weights(static_cast<std::size_t>(length), 0);
    double sum = 0;
    for (std::size_t q = 0; q < profile.offset.size(); ++q) {
      double x =
          (static_cast<double>(s) - map->offset[op.axis]) / map->scale[op.axis] + profile.offset[q] / spacing;
      if (x < -0.5 - 1e-6 || x > static_cast<double>(length) - 0.5 + 1e-6) continue;
      x = std::clamp(x, 0.0, static_cast<double>(length - 1));
      const auto below = std::min(static_cast<std::int64_t>(x), std::max<std::int64_t>(0, length - 2));
      const double f = x - static_cast<double>(below);
      weights[below] += profile.weight[q] * (1 - f);
      if (below + 1 < length) weights[below + 1] += profile.weight[q] * f;
      sum += profile.weight[q];
    }
    for (std::int64_t v = 0; v < length; ++v)
      if (sum > 0 && weights[v] / sum > 1e-9) {
        const auto weight = static_cast<float>(weights[v] / sum);
        op.voxels[s].push_back({v, weight});
        op.slices[v].push_back({s, weight});
      }
  }
  op.target.resize(stack.image.voxels.size());
  for (std::size_t v = 0; v < op.target.size(); ++v) {
    const bool known = stack.observed.empty() || stack.observed[v];
    op.target[v] =
        known ? static_cast<float>(stack.image.voxels[v] / scale) : std::numeric_limits<float>::quiet_NaN();
  }
  op.dual.assign(op.target.size(), 0.f);
  return op;
}

} // namespace

Volume totalVariation(std::span<const Stack> stacks, const GridGeometry& grid,
                      const TotalVariationSettings& settings) {
  const ValueRange range = observedRange(stacks);
  const double scale = range.high > range.low ? static_cast<double>(range.high) - range.low : 1;
  std::vector<BlurOperator> operators;
  for (const Stack& stack : stacks)
    operators.push_back(makeOperator(stack, grid, scale));
  Volume volume = averageUpsampled(stacks, grid, Interpolation::Cubic, settings.threads, settings.stop);
  for (float& value : volume.voxels)
    value = static_cast<float>(value / scale);

  ThreadPool pool(settings.threads);
  pool.setStop(settings.stop);
  const std::int64_t nx = grid.size[0], ny = grid.size[1], nz = grid.size[2];
  const std::int64_t strides[3] = {1, nx, nx * ny};
  std::vector<float>& x = volume.voxels;
  std::vector<float> ahead = x; // extrapolated
  std::array<std::vector<float>, 3> dual;
  for (auto& component : dual)
    component.assign(x.size(), 0.f);
  const auto lambda = static_cast<float>(settings.weight);
  constexpr float gradientStep = 0.5f, sliceStep = 1.f; // 1 / row sums of the gradient and of A

  for (int iteration = 0; iteration < settings.iterations; ++iteration) {
    pool.run(nz, [&](std::int64_t k) {
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = 0; i < nx; ++i) {
          const std::int64_t v = i + nx * j + nx * ny * k;
          const bool inside[3] = {i + 1 < nx, j + 1 < ny, k + 1 < nz};
          float next[3], squares = 0;
          for (int a = 0; a < 3; ++a) {
            next[a] = inside[a] ? dual[a][v] + gradientStep * (ahead[v + strides[a]] - ahead[v]) : 0.f;
            squares += next[a] * next[a];
          }
          const float shrink = squares > lambda * lambda ? lambda / std::sqrt(squares) : 1.f;
          for (int a = 0; a < 3; ++a)
            dual[a][v] = next[a] * shrink;
        }
    });
    for (BlurOperator& op : operators) {
      const int u = op.axis == 0 ? 1 : 0, w = op.axis == 2 ? 1 : 2; // in-plane axes of the grid
      pool.run(static_cast<std::int64_t>(op.voxels.size()), [&](std::int64_t s) {
        std::array<std::int64_t, 3> at{};
        for (at[w] = 0; at[w] < grid.size[w]; ++at[w])
          for (at[u] = 0; at[u] < grid.size[u]; ++at[u]) {
            const std::int64_t sample = op.sample(at, s);
            if (!std::isfinite(op.target[sample])) continue;
            const std::int64_t column = at[u] * strides[u] + at[w] * strides[w];
            float seen = 0;
            for (const Tap& tap : op.voxels[s])
              seen += tap.weight * ahead[column + tap.index * strides[op.axis]];
            op.dual[sample] = (op.dual[sample] + sliceStep * (seen - op.target[sample])) / (1 + sliceStep);
          }
      });
    }
    pool.run(nz, [&](std::int64_t k) {
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = 0; i < nx; ++i) {
          const std::array<std::int64_t, 3> at{i, j, k};
          const std::int64_t v = i + nx * j + nx * ny * k;
          float descent = 0, columnSum = 6;
          for (int a = 0; a < 3; ++a)
            descent += dual[a][v] - (at[a] > 0 ? dual[a][v - strides[a]] : 0.f);
          for (const BlurOperator& op : operators)
            for (const Tap& tap : op.slices[at[op.axis]]) {
              descent -= tap.weight * op.dual[op.sample(at, tap.index)];
              columnSum += tap.weight;
            }
          const float before = x[v];
          x[v] += descent / columnSum;
          ahead[v] = 2 * x[v] - before;
        }
    });
  }
  for (float& value : x)
    value = static_cast<float>(value * scale);
  return volume;
}

} // namespace innergs
