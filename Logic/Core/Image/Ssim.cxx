#include "Core/Image/Ssim.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs {
namespace {

constexpr int radius = 5;

std::array<double, 2 * radius + 1> window() {
  std::array<double, 2 * radius + 1> weights{};
  double sum = 0;
  for (int t = -radius; t <= radius; ++t)
    sum += weights[t + radius] = std::exp(-0.5 * t * t / (1.5 * 1.5));
  for (double& w : weights)
    w /= sum;
  return weights;
}

// … b a | a b c …, for slices narrower than the window too.
int reflect(int i, int n) {
  const int period = 2 * n;
  i %= period;
  if (i < 0) i += period;
  return i < n ? i : period - 1 - i;
}

class Blur {
public:
  Blur(int width, int height)
      : width_(width), height_(height), padded_(static_cast<std::size_t>(width) + 2 * radius),
        rows_(static_cast<std::size_t>(width) * height) {}

  void operator()(std::vector<double>& image) {
    for (int y = 0; y < height_; ++y) {
      const double* in = image.data() + std::size_t(y) * width_;
      for (int x = -radius; x < width_ + radius; ++x)
        padded_[x + radius] = in[reflect(x, width_)];
      double* out = rows_.data() + std::size_t(y) * width_;
      std::fill_n(out, width_, 0.0);
      for (int t = 0; t <= 2 * radius; ++t) {
        const double w = weights_[t], *shifted = padded_.data() + t;
        for (int x = 0; x < width_; ++x)
          out[x] += w * shifted[x];
      }
    }
    for (int y = 0; y < height_; ++y) {
      double* out = image.data() + std::size_t(y) * width_;
      std::fill_n(out, width_, 0.0);
      for (int t = -radius; t <= radius; ++t) {
        const double w = weights_[t + radius],
                     *in = rows_.data() + std::size_t(reflect(y + t, height_)) * width_;
        for (int x = 0; x < width_; ++x)
          out[x] += w * in[x];
      }
    }
  }

private:
  int width_, height_;
  std::vector<double> padded_, rows_;
  std::array<double, 2 * radius + 1> weights_ = window();
};

} // namespace

std::vector<float> ssimMap(std::span<const float> image, std::span<const float> truth, int width, int height,
                           double range) {
  const auto n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  // Subtracts a common shift first: large offsets (CT) would cancel in the variances.
  double shift = 0;
  std::size_t finite = 0;
  for (std::size_t p = 0; p < n; ++p)
    if (std::isfinite(truth[p])) {
      shift += truth[p];
      ++finite;
    }
  if (finite) shift /= double(finite);

  std::vector<double> a(n), b(n), aa(n), bb(n), ab(n);
  for (std::size_t p = 0; p < n; ++p) {
    // A voxel without truth counts as equal, so it does not distort its neighbours' windows.
    const bool known = std::isfinite(truth[p]);
    a[p] = known ? image[p] - shift : 0;
    b[p] = known ? truth[p] - shift : 0;
    aa[p] = a[p] * a[p];
    bb[p] = b[p] * b[p];
    ab[p] = a[p] * b[p];
  }
  Blur blur(width, height);
  for (auto* plane : {&a, &b, &aa, &bb, &ab})
    blur(*plane);
  const double c1 = std::pow(0.01 * range, 2), c2 = std::pow(0.03 * range, 2);
  std::vector<float> map(n);
  for (std::size_t p = 0; p < n; ++p) {
    const double varianceA = std::max(0.0, aa[p] - a[p] * a[p]),
                 varianceB = std::max(0.0, bb[p] - b[p] * b[p]);
    const double covariance = ab[p] - a[p] * b[p], meanA = a[p] + shift, meanB = b[p] + shift;
    const double denominator = (meanA * meanA + meanB * meanB + c1) * (varianceA + varianceB + c2);
    map[p] = denominator > 0
                 ? static_cast<float>((2 * meanA * meanB + c1) * (2 * covariance + c2) / denominator)
                 : 1.0f;
  }
  return map;
}

} // namespace innergs
