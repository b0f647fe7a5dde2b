#include "Core/Alignment/HistogramSharpening.h"

#include "Core/Base/Cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr int kBins = 400, kPadded = 1024, kBefore = (kPadded - kBins) / 2;
constexpr double kMargin = 0.3;  // of the logarithms, for values that move
constexpr double kWiener = 0.01; // noise of the histogram
constexpr double kRidge = 1e-4;
constexpr std::size_t kFewest = 1000;

/// Full width at half maximum of the shading's own histogram, widest first.
struct Pass {
  double width;
  int iterations;
};
constexpr Pass kPasses[] = {{0.15, 20}, {0.1, 20}, {0.07, 20}, {0.05, 30}, {0.035, 30}, {0.025, 30}};

using Bins = std::array<double, kPadded>;

/// The circular convolution with a symmetric kernel.
Bins convolved(const Bins& values, const Bins& kernel) {
  Bins result{};
  for (int i = 0; i < kPadded; ++i) {
    if (values[i] == 0) continue;
    for (int j = 0; j < kPadded; ++j)
      result[j] += values[i] * kernel[(j - i) & (kPadded - 1)];
  }
  return result;
}

/// The Gaussian and the Wiener filter that undoes it; sigma: bins.
void makeKernels(double sigma, Bins& blur, Bins& sharpen) {
  double sum = 0;
  for (int t = 0; t < kPadded; ++t) {
    const double x = std::min(t, kPadded - t) / sigma;
    sum += blur[t] = std::exp(-0.5 * x * x);
  }
  for (double& b : blur)
    b /= sum;
  Bins wave, spectrum{};
  for (int t = 0; t < kPadded; ++t)
    wave[t] = std::cos(2 * std::numbers::pi * t / kPadded);
  for (int f = 0; f < kPadded; ++f) {
    for (int t = 0; t < kPadded; ++t)
      spectrum[f] += blur[t] * wave[f * t & (kPadded - 1)];
    spectrum[f] /= spectrum[f] * spectrum[f] + kWiener;
  }
  for (int t = 0; t < kPadded; ++t) {
    sharpen[t] = 0;
    for (int f = 0; f < kPadded; ++f)
      sharpen[t] += spectrum[f] * wave[f * t & (kPadded - 1)];
    sharpen[t] /= kPadded;
  }
}

} // namespace

std::vector<double> sharpestShading(std::span<const double> logs, std::span<const double> terms, int count,
                                    const std::function<void()>& throwIfStopped) {
  std::vector<double> found(static_cast<std::size_t>(count));
  if (logs.size() < kFewest) return {};
  const auto [least, most] = std::minmax_element(logs.begin(), logs.end());
  const double low = *least - kMargin, step = (*most - *least + 2 * kMargin) / (kBins - 1);
  // The constant takes part in the equations, but the shading has none.
  const int unknowns = count + 1;
  const auto n = static_cast<double>(logs.size());
  std::vector<double> gram(static_cast<std::size_t>(unknowns) * unknowns);
  const auto term = [&](std::size_t v, int c) { return c < count ? terms[v * count + c] : 1.0; };
  for (std::size_t v = 0; v < logs.size(); ++v)
    for (int a = 0; a < unknowns; ++a)
      for (int b = 0; b <= a; ++b)
        gram[a * unknowns + b] += term(v, a) * term(v, b) / n;
  for (int a = 0; a < unknowns; ++a)
    gram[a * (unknowns + 1)] += kRidge;
  std::vector<double> left(logs.begin(), logs.end()); // without the shading
  Bins blur, sharpen, place;
  for (int t = 0; t < kPadded; ++t)
    place[t] = low + (t - kBefore) * step;
  for (const Pass& pass : kPasses) {
    makeKernels(pass.width / 2.3548 / step, blur, sharpen);
    for (int iteration = 0; iteration < pass.iterations; ++iteration) {
      throwIfStopped();
      Bins histogram{};
      const auto binOf = [&](double value, double& share) {
        const double at = std::clamp((value - low) / step, 0.0, kBins - 1.0);
        const int bin = std::min(static_cast<int>(at), kBins - 2);
        share = at - bin;
        return bin + kBefore;
      };
      for (const double value : left) {
        double share;
        const int bin = binOf(value, share);
        histogram[bin] += 1 - share;
        histogram[bin + 1] += share;
      }
      Bins sharp = convolved(histogram, sharpen), weighted;
      for (int t = 0; t < kPadded; ++t) {
        sharp[t] = std::max(sharp[t], 0.0);
        weighted[t] = sharp[t] * place[t];
      }
      const Bins sum = convolved(weighted, blur), weight = convolved(sharp, blur);
      Bins expected{}; // the sharp value behind each value
      for (int t = 0; t < kPadded; ++t)
        expected[t] = weight[t] > 1e-9 ? sum[t] / weight[t] : place[t];
      std::vector<double> square = gram, right(static_cast<std::size_t>(unknowns));
      for (std::size_t v = 0; v < left.size(); ++v) {
        double share;
        const int bin = binOf(left[v], share);
        const double rest = left[v] - (1 - share) * expected[bin] - share * expected[bin + 1];
        for (int c = 0; c < unknowns; ++c)
          right[c] += term(v, c) * rest / n;
      }
      solveCholesky(square, right, unknowns, 1);
      for (int c = 0; c < count; ++c)
        found[c] += right[c];
      for (std::size_t v = 0; v < left.size(); ++v)
        for (int c = 0; c < count; ++c)
          left[v] -= right[c] * terms[v * count + c];
    }
  }
  return found;
}

} // namespace innergs
