#include "Core/Fit/LossSsim.h"

#include "Core/Fit/PointLoss.h"

#include <algorithm>
#include <vector>

namespace innergs {
namespace {

/// Separable and zero-padded, hence self-adjoint. Tightly packed nx×ny.
void filter(std::vector<float>& image, int nx, int ny, std::vector<float>& scratch) {
  static const auto w = ssimWindow();
  scratch.assign(image.size(), 0.f);
  for (int y = 0; y < ny; ++y)
    for (int k = -kSsimRadius; k <= kSsimRadius; ++k) {
      const int a = std::max(0, -k), b = std::min(nx, nx - k);
      for (int x = a; x < b; ++x)
        scratch[y * nx + x] += w[k + kSsimRadius] * image[y * nx + x + k];
    }
  image.assign(image.size(), 0.f);
  for (int y = 0; y < ny; ++y)
    for (int k = std::max(-kSsimRadius, -y); k <= std::min(kSsimRadius, ny - 1 - y); ++k)
      for (int x = 0; x < nx; ++x)
        image[y * nx + x] += w[k + kSsimRadius] * scratch[(y + k) * nx + x];
}

} // namespace

double addSsimLoss(const float* image, const float* target, const std::uint8_t* weight, int nx, int ny,
                   int stride, double ssimWeight, float* gradient) {
  const std::size_t n = static_cast<std::size_t>(nx) * ny;
  std::vector<float> x(n), y(n), mx(n), my(n), xx(n), yy(n), xy(n), scratch;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const std::size_t p = static_cast<std::size_t>(j) * nx + i,
                        v = static_cast<std::size_t>(j) * stride + i;
      y[p] = target[v];
      x[p] = weight[v] ? image[v] : target[v];
      xx[p] = x[p] * x[p];
      yy[p] = y[p] * y[p];
      xy[p] = x[p] * y[p];
    }
  mx = x;
  my = y;
  for (auto* m : {&mx, &my, &xx, &yy, &xy})
    filter(*m, nx, ny, scratch);
  double loss = 0;
  std::vector<float> dMean(n), dSquare(n), dProduct(n);
  for (std::size_t p = 0; p < n; ++p) {
    const SsimTerm term = ssimTerm(mx[p], my[p], xx[p], yy[p], xy[p]);
    loss += 1 - term.ssim;
    dMean[p] = term.dMean;
    dSquare[p] = term.dSquare;
    dProduct[p] = term.dProduct;
  }
  for (auto* m : {&dMean, &dSquare, &dProduct})
    filter(*m, nx, ny, scratch);
  const float s = static_cast<float>(ssimWeight);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const std::size_t p = static_cast<std::size_t>(j) * nx + i,
                        v = static_cast<std::size_t>(j) * stride + i;
      if (weight[v]) gradient[v] -= s * (dMean[p] + 2 * x[p] * dSquare[p] + y[p] * dProduct[p]);
    }
  return ssimWeight * loss;
}

} // namespace innergs
