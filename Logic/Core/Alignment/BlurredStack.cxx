#include "Core/Alignment/BlurredStack.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr float kLeastObserved = 0.3f; // share of the kernel that must have been observed
constexpr double kLeastCorners = 0.99; // share of the eight neighbours

/// Blurs sums and weights along one axis in place, by a Gaussian of σ voxels.
void blurAlong(int axis, double sigma, const std::array<std::int64_t, 3>& size, std::vector<float>& sum,
               std::vector<float>& weight, ThreadPool& pool) {
  if (sigma < 0.1) return;
  const auto reach = static_cast<std::int64_t>(std::ceil(3 * sigma));
  std::vector<float> kernel;
  float whole = 0;
  for (std::int64_t t = -reach; t <= reach; ++t) {
    const double x = static_cast<double>(t) / sigma;
    kernel.push_back(static_cast<float>(std::exp(-0.5 * x * x)));
    whole += kernel.back();
  }
  for (float& k : kernel)
    k /= whole;
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
  const std::int64_t lines = size[0] * size[1] * size[2] / size[axis], n = size[axis];
  pool.blocks(lines, 256, [&](std::int64_t from, std::int64_t to) {
    std::vector<float> s(static_cast<std::size_t>(n)), w(static_cast<std::size_t>(n));
    for (std::int64_t line = from; line < to; ++line) {
      const std::int64_t start = axis == 0   ? line * size[0]
                                 : axis == 1 ? line / size[0] * size[0] * size[1] + line % size[0]
                                             : line;
      for (std::int64_t i = 0; i < n; ++i) {
        s[i] = sum[start + i * stride];
        w[i] = weight[start + i * stride];
      }
      for (std::int64_t i = 0; i < n; ++i) {
        float a = 0, b = 0;
        for (std::int64_t t = std::max(-reach, -i); t <= std::min(reach, n - 1 - i); ++t) {
          a += kernel[t + reach] * s[i + t];
          b += kernel[t + reach] * w[i + t];
        }
        sum[start + i * stride] = a;
        weight[start + i * stride] = b;
      }
    }
  });
}

} // namespace

double resolutionVariance(const Stack& stack, int axis) {
  const double spacing = stack.image.geometry.spacing[axis];
  if (axis < 2) return spacing * spacing / 4; // a pixel and linear interpolation
  const double thickness = stack.profile == SliceProfile::Point ? 0
                           : stack.thickness > 0                ? stack.thickness
                                                                : spacing;
  return thickness * thickness / 12 + spacing * spacing / 6;
}

double commonResolution(std::span<const Stack> stacks, std::span<const std::size_t> part) {
  double sigma = 0;
  for (const std::size_t s : part)
    for (int axis = 0; axis < 3; ++axis)
      sigma = std::max(sigma, std::sqrt(resolutionVariance(stacks[s], axis)));
  return sigma;
}

BlurredStack::BlurredStack(const Stack& stack, double sigma, ThreadPool& pool)
    : geometry_(stack.image.geometry), worldToIndex_(inverse(stack.image.geometry.indexToWorld())),
      value_(stack.image.voxels.size()) {
  std::vector<float> weight(value_.size());
  for (std::size_t v = 0; v < value_.size(); ++v) {
    const bool seen = isKnown(stack, v);
    value_[v] = seen ? stack.image.voxels[v] : 0;
    weight[v] = seen;
  }
  for (int axis = 0; axis < 3; ++axis)
    blurAlong(axis,
              std::sqrt(std::max(0.0, sigma * sigma - resolutionVariance(stack, axis))) /
                  geometry_.spacing[axis],
              geometry_.size, value_, weight, pool);
  for (std::size_t v = 0; v < value_.size(); ++v)
    value_[v] = weight[v] > kLeastObserved ? value_[v] / weight[v] : std::numeric_limits<float>::quiet_NaN();
}

std::optional<double> BlurredStack::at(const Vec3& x) const {
  const Vec3 p = worldToIndex_(x);
  std::int64_t base[3];
  double f[3];
  for (int a = 0; a < 3; ++a) {
    if (!(p[a] >= 0 && p[a] <= static_cast<double>(geometry_.size[a] - 1))) return {};
    base[a] = std::min(static_cast<std::int64_t>(p[a]), std::max<std::int64_t>(0, geometry_.size[a] - 2));
    f[a] = p[a] - static_cast<double>(base[a]);
  }
  double sum = 0, weight = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double w = 1;
    std::int64_t v = 0;
    for (int a = 2; a >= 0; --a) {
      const int high = corner >> a & 1;
      w *= high ? f[a] : 1 - f[a];
      v = v * geometry_.size[a] + std::min(base[a] + high, geometry_.size[a] - 1);
    }
    if (w == 0 || std::isnan(value_[v])) continue;
    sum += w * value_[v];
    weight += w;
  }
  if (weight < kLeastCorners) return {};
  return sum / weight;
}

} // namespace innergs
