#include "Core/Prediction/CandidateChoice.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/Observation.h"
#include "Core/Image/BodyMask.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace innergs {
namespace {

constexpr std::int64_t kSlices = 12;                                   // at most, whose images are degraded
constexpr std::int64_t kLineSamples = 200'000;                         // of the images along one axis, about
constexpr std::int64_t kFewest = 500;                                  // minimum to judge by
constexpr double kBlurs[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1}; // in slice distances
constexpr int kPlausible = 3;                                          // blurs that the choice hedges between
constexpr double kTemperature = 0.2; // of misfits: a blur that fits worse by this much counts 1/e as much
constexpr int kClassical = 3;        // candidates without a blur
constexpr double kKrigingBlurs[] = {0, 0.15, 0.25, 0.35, 0.5, 0.7, 1}; // in slice distances
constexpr double kAsGood = 1.01;                                       // ratio of squared errors
constexpr double kFine = 1.5;                                          // minimum slice distance, in pixels
constexpr double kLevel = 0.1;                                         // weight of the errors' size
constexpr int kSteps = 20;                                             // divisions of a share
constexpr int kBackProjections = 12;
constexpr float kNegligibleWeight = 1e-6F; // weight of a slice

/// Samples along an axis: value[n·width + line].
struct Lines {
  std::int64_t length = 0, width = 0;
  std::vector<float> value;
  std::vector<std::uint8_t> inside;
};

/// Filters row n of values [length][width].
void filterRow(const float* values, std::int64_t length, std::int64_t width, std::span<const double> kernel,
               std::int64_t n, float* to) {
  const auto reach = static_cast<std::int64_t>(kernel.size() / 2);
  std::fill_n(to, width, 0.f);
  for (std::int64_t t = -reach; t <= reach; ++t) {
    const float* from = values + std::clamp<std::int64_t>(n + t, 0, length - 1) * width;
    const auto w = static_cast<float>(kernel[t + reach]);
    for (std::int64_t i = 0; i < width; ++i)
      to[i] += w * from[i];
  }
}

/// Every factor-th row of the filtered values.
std::vector<float> sampled(const std::vector<float>& values, std::int64_t length, std::int64_t width,
                           std::span<const double> kernel, std::int64_t factor = 1) {
  const std::int64_t rows = (length - 1) / factor + 1;
  std::vector<float> out(static_cast<std::size_t>(rows * width));
  for (std::int64_t n = 0; n < rows; ++n)
    filterRow(values.data(), length, width, kernel, n * factor, out.data() + n * width);
  return out;
}

std::vector<double> normalised(std::vector<double> kernel) {
  double sum = 0;
  for (const double w : kernel)
    sum += w;
  for (double& w : kernel)
    w /= sum;
  return kernel;
}

std::vector<double> gaussianKernel(double sigma) {
  if (sigma < 1e-3) return {1};
  const auto reach = static_cast<std::int64_t>(std::ceil(3.5 * sigma));
  std::vector<double> kernel;
  for (std::int64_t t = -reach; t <= reach; ++t)
    kernel.push_back(std::exp(-0.5 * static_cast<double>(t * t) / (sigma * sigma)));
  return normalised(std::move(kernel));
}

/// A slice's profile, in samples along the axis.
std::vector<double> profileKernel(const Stack& stack, double sample) {
  const double width = effectiveThickness(stack) / sample;
  if (stack.profile == SliceProfile::Point || width < 1.2) return {1};
  if (stack.profile == SliceProfile::Gaussian) return gaussianKernel(width / kFwhm);
  const auto reach = static_cast<std::int64_t>(std::ceil(0.5 * width - 0.5));
  std::vector<double> kernel;
  for (std::int64_t t = -reach; t <= reach; ++t) {
    const double low = std::max(-0.5 * width, static_cast<double>(t) - 0.5),
                 high = std::min(0.5 * width, static_cast<double>(t) + 0.5);
    kernel.push_back(std::max(0.0, high - low));
  }
  return normalised(std::move(kernel));
}

/// Keeps every factor-th sample.
Lines decimated(const Lines& in, std::int64_t factor, std::int64_t phase = 0) {
  Lines out;
  out.length = in.length > phase ? (in.length - 1 - phase) / factor + 1 : 0;
  out.width = in.width;
  for (std::int64_t n = 0; n < out.length; ++n) {
    const std::int64_t at = (phase + n * factor) * in.width;
    out.value.insert(out.value.end(), in.value.begin() + at, in.value.begin() + at + in.width);
    out.inside.insert(out.inside.end(), in.inside.begin() + at, in.inside.begin() + at + in.width);
  }
  return out;
}

/// low: [slice][width].
std::vector<float> interpolated(const std::vector<float>& low, std::int64_t width,
                                const SliceWeights& weights) {
  std::vector<float> out(weights.first.size() * static_cast<std::size_t>(width), 0.f);
  for (std::size_t z = 0; z < weights.first.size(); ++z) {
    float* to = out.data() + static_cast<std::int64_t>(z) * width;
    for (std::size_t t = 0; t < weights.weight[z].size(); ++t) {
      const float w = weights.weight[z][t];
      const float* from = low.data() + (weights.first[z] + static_cast<std::int64_t>(t)) * width;
      for (std::int64_t i = 0; i < width; ++i)
        to[i] += w * from[i];
    }
  }
  return out;
}

/// Sums of products of the candidates' errors.
struct Errors {
  Covariance<kCandidates> sum{};
  std::int64_t samples = 0;

  void add(const Errors& other) {
    for (int a = 0; a < kCandidates; ++a)
      for (int b = 0; b < kCandidates; ++b)
        sum[a][b] += other.sum[a][b];
    samples += other.samples;
  }
  Covariance<kCandidates> mean() const {
    Covariance<kCandidates> mean = sum;
    for (auto& row : mean)
      for (double& x : row)
        x /= static_cast<double>(std::max<std::int64_t>(1, samples));
    return mean;
  }
};

using Guesses = std::array<std::vector<float>, kCandidates>; // empty: left out

/// counts(row): whether a row of the truth is scored.
template <class Counts>
Errors errorsOf(const Lines& truth, const Guesses& guess, const Counts& counts) {
  Errors errors;
  std::vector<int> given;
  for (int c = 0; c < kCandidates; ++c)
    if (!guess[c].empty()) given.push_back(c);
  for (std::int64_t n = 0; n < truth.length; ++n) {
    if (!counts(n)) continue;
    for (std::int64_t i = n * truth.width; i < (n + 1) * truth.width; ++i) {
      if (!truth.inside[i]) continue;
      double e[kCandidates];
      for (const int c : given)
        e[c] = static_cast<double>(guess[c][i]) - truth.value[i];
      for (const int a : given)
        for (const int b : given)
          if (b <= a) errors.sum[a][b] += e[a] * e[b];
      ++errors.samples;
    }
  }
  for (int a = 0; a < kCandidates; ++a)
    for (int b = a + 1; b < kCandidates; ++b)
      errors.sum[a][b] = errors.sum[b][a];
  return errors;
}

std::vector<double> positions(std::int64_t count, double perSample) {
  std::vector<double> p;
  for (std::int64_t n = 0; n < count; ++n)
    p.push_back(static_cast<double>(n) * perSample);
  return p;
}

/// How slices sample the axis; lengths in slice distances.
struct SliceView {
  SliceProfile profile = SliceProfile::Point;
  double thickness = 0;
};

using Weights = std::array<SliceWeights, kCandidates>; // empty: left out

/// The candidates from `first` on, for lines of `length` slices.
Weights weightsFrom(std::int64_t length, std::span<const double> at, const SliceView& view, double blur,
                    int first = 0) {
  Weights weights;
  const Kriging kriging(blur, view.profile, view.thickness);
  for (int c = first; c < kCandidates; ++c)
    weights[c] = candidateWeights(static_cast<Candidate>(c), kriging, length, at);
  return weights;
}

Guesses guessesBy(const Weights& weights, const Lines& low) {
  Guesses guess;
  for (int c = 0; c < kCandidates; ++c)
    if (!weights[c].first.empty()) guess[c] = interpolated(low.value, low.width, weights[c]);
  return guess;
}

/// The candidates' errors on slices held out from their neighbours, alternating between even and odd ones.
Errors heldOutErrors(const Lines& slices, const SliceView& view, double blur) {
  // Here the kriging must predict the slices themselves, not the signal that they see.
  const double profileVariance = view.profile == SliceProfile::Point ? 0
                                 : view.profile == SliceProfile::Box
                                     ? view.thickness * view.thickness / 12
                                     : view.thickness * view.thickness / (8 * std::numbers::ln2);
  const double seenBlur = std::sqrt(blur * blur + profileVariance);
  Errors errors;
  for (std::int64_t phase = 0; phase < 2; ++phase) {
    const Lines kept = decimated(slices, 2, phase);
    if (kept.length < 3) continue;
    std::vector<double> at;
    for (std::int64_t n = 0; n < slices.length; ++n)
      at.push_back(0.5 * static_cast<double>(n - phase));
    const Guesses guess = guessesBy(weightsFrom(kept.length, at, {}, 0.5 * seenBlur), kept);
    errors.add(errorsOf(slices, guess, [&](std::int64_t n) {
      return (n - phase) % 2 != 0 && n > phase && n < phase + 2 * (kept.length - 1);
    }));
  }
  return errors;
}

/// The back-projection step along the axis: x += U S(low − P x), with the weights of spreadingWeights() as S.
void backProjectLines(std::vector<float>& x, const Lines& low, std::int64_t length,
                      std::span<const double> profile, std::int64_t factor, std::span<const double> spreading,
                      const SliceWeights& linear) {
  for (int iteration = 0; iteration < kBackProjections; ++iteration) {
    std::vector<float> rest = sampled(x, length, low.width, profile, factor);
    for (std::size_t i = 0; i < rest.size(); ++i)
      rest[i] = low.value[i] - rest[i];
    if (spreading.size() > 1) rest = sampled(rest, low.length, low.width, spreading);
    const std::vector<float> step = interpolated(rest, low.width, linear);
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += step[i];
  }
}

/// How often the strongest changes over two slices have an intermediate value in the slice between: 0 for
/// steps, 1 for slopes.
double slopeShare(const Lines& slices) {
  std::vector<float> change;
  const auto visit = [&](auto&& see) {
    for (std::int64_t n = 1; n + 1 < slices.length; ++n)
      for (std::int64_t i = n * slices.width; i < (n + 1) * slices.width; ++i) {
        const std::int64_t below = i - slices.width, above = i + slices.width;
        if (slices.inside[below] && slices.inside[i] && slices.inside[above])
          see(slices.value[below], slices.value[i], slices.value[above]);
      }
  };
  visit([&](float a, float, float c) { change.push_back(std::abs(c - a)); });
  if (static_cast<std::int64_t>(change.size()) < kFewest) return 0;
  const auto strong = change.begin() + static_cast<std::ptrdiff_t>(change.size() * 4 / 5);
  std::nth_element(change.begin(), strong, change.end());
  const float threshold = std::max(*strong, std::numeric_limits<float>::min());
  double sum = 0, count = 0;
  visit([&](float a, float b, float c) {
    if (std::abs(c - a) < threshold) return;
    const double p = std::clamp((static_cast<double>(b) - a) / (static_cast<double>(c) - a), 0.0, 1.0);
    sum += 4 * p * (1 - p);
    ++count;
  });
  return count > 0 ? sum / count : 0;
}

/// The slices themselves, at a regular subset of the columns.
Lines linesAcross(const Stack& stack, std::span<const float> complete, std::span<const std::uint8_t> inside) {
  const auto& size = stack.image.geometry.size;
  const std::int64_t plane = size[0] * size[1], step = std::max<std::int64_t>(1, plane * size[2] / 2'000'000);
  Lines lines;
  lines.length = size[2];
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t p = 0; p < plane; p += step) {
      lines.value.push_back(complete[k * plane + p]);
      lines.inside.push_back(inside[k * plane + p]);
    }
  lines.width = static_cast<std::int64_t>(lines.value.size()) / std::max<std::int64_t>(1, lines.length);
  return lines;
}

/// Lines along an in-plane axis of some of the slices.
Lines linesWithin(const Stack& stack, std::span<const float> complete, std::span<const std::uint8_t> inside,
                  int axis) {
  const auto& size = stack.image.geometry.size;
  const std::int64_t slices = std::min(kSlices, size[2]), other = size[1 - axis];
  const std::int64_t step = std::max<std::int64_t>(1, slices * other * size[axis] / kLineSamples);
  std::vector<std::int64_t> starts;
  for (std::int64_t s = 0; s < slices; ++s) {
    const std::int64_t k = (2 * s + 1) * size[2] / (2 * slices);
    for (std::int64_t q = s % step; q < other; q += step)
      starts.push_back(k * size[0] * size[1] + q * (axis == 0 ? size[0] : 1));
  }
  Lines lines;
  lines.length = size[axis];
  lines.width = static_cast<std::int64_t>(starts.size());
  const std::int64_t stride = axis == 0 ? 1 : size[0];
  for (std::int64_t n = 0; n < lines.length; ++n)
    for (const std::int64_t start : starts) {
      lines.value.push_back(complete[start + n * stride]);
      lines.inside.push_back(inside[start + n * stride]);
    }
  return lines;
}

/// Images along one in-plane axis, blurred, and what slices that far apart would show of them.
struct Degraded {
  Lines truth, low;
  std::int64_t factor = 0; // low.length to truth.length
  std::vector<double> profile, at;
  SliceView view;
};

/// The outcome of one blur of the in-plane images.
struct Simulation {
  double blur = 0; // mm
  std::vector<Degraded> images;
  Errors plain, projected; // against the images; with back-projection
  Errors heldOut;          // from heldOutErrors() on their slices
  double slopeSum = 0;     // over the axes that show one
  int slopes = 0;
  double weight = 1; // by its misfit, relative to the best

  const Errors& best() const { return projected.samples > 0 ? projected : plain; }
  double slope() const { return slopes > 0 ? slopeSum / slopes : 0; }
};

/// Adds the images, unless they are too short.
void degrade(const Lines& image, const Stack& stack, double sample, Simulation& result) {
  const double distance = stack.image.geometry.spacing[2] / sample;
  Degraded d;
  d.factor = std::max<std::int64_t>(2, std::llround(distance));
  d.truth = image;
  d.truth.value = sampled(image.value, image.length, image.width, gaussianKernel(result.blur / sample));
  d.truth.length = (d.truth.length - 1) / d.factor * d.factor + 1;
  d.truth.value.resize(d.truth.length * d.truth.width);
  d.truth.inside.resize(d.truth.value.size());
  if (d.truth.length < 4 * d.factor) return;
  d.profile = profileKernel(stack, sample);
  d.low = decimated(d.truth, d.factor);
  d.low.value = sampled(d.truth.value, d.truth.length, d.truth.width, d.profile, d.factor);
  d.at = positions(d.truth.length, 1.0 / static_cast<double>(d.factor));
  d.view = {d.profile.size() > 1 ? stack.profile : SliceProfile::Point,
            effectiveThickness(stack) / sample / static_cast<double>(d.factor)};
  result.images.push_back(std::move(d));
}

/// For lines of one length: the candidates as they are, and with back-projection, which is linear too, where
/// slices are thick.
struct LineWeights {
  Weights plain, projected;
};

/// The same interpolation, followed by back-projection.
SliceWeights projected(const SliceWeights& weights, const Degraded& d, std::span<const double> spreading,
                       const SliceWeights& linear) {
  const std::int64_t n = d.low.length;
  Lines single; // one line per slice, which alone is 1 in it
  single.length = single.width = n;
  single.value.assign(static_cast<std::size_t>(n * n), 0.f);
  for (std::int64_t k = 0; k < n; ++k)
    single.value[k * n + k] = 1;
  std::vector<float> x = interpolated(single.value, n, weights);
  backProjectLines(x, single, d.truth.length, d.profile, d.factor, spreading, linear);
  SliceWeights result;
  for (std::int64_t z = 0; z < d.truth.length; ++z) {
    const float* row = x.data() + z * n;
    std::int64_t first = 0, end = n;
    while (first + 1 < end && std::abs(row[first]) < kNegligibleWeight)
      ++first;
    while (end - 1 > first && std::abs(row[end - 1]) < kNegligibleWeight)
      --end;
    result.first.push_back(first);
    result.weight.emplace_back(row + first, row + end);
  }
  return result;
}

LineWeights lineWeights(const Degraded& d, double krigingBlur, int first = 0) {
  LineWeights weights{weightsFrom(d.low.length, d.at, d.view, krigingBlur, first), {}};
  if (d.profile.size() == 1) return weights;
  const SliceWeights linear =
      candidateWeights(Candidate::Linear, Kriging(0, SliceProfile::Point, 0), d.low.length, d.at);
  const std::vector<double> spreading = spreadingWeights(d.view.profile, d.view.thickness);
  for (int c = first; c < kCandidates; ++c)
    if (!weights.plain[c].first.empty())
      weights.projected[c] = projected(weights.plain[c], d, spreading, linear);
  return weights;
}

/// The errors of interpolation, and of back-projection where slices are thick.
void addErrors(const Degraded& d, const LineWeights& weights, Errors& plain, Errors& projected) {
  const bool thick = d.profile.size() > 1;
  const auto counts = [&](std::int64_t n) { return thick || n % d.factor != 0; };
  plain.add(errorsOf(d.truth, guessesBy(weights.plain, d.low), counts));
  if (thick) projected.add(errorsOf(d.truth, guessesBy(weights.projected, d.low), counts));
}

/// The weights for the images along each axis, which are of the same lengths in all simulations.
std::vector<LineWeights> weightsOfAxes(const Simulation& any, double krigingBlur) {
  std::vector<LineWeights> weights;
  for (const Degraded& d : any.images)
    weights.push_back(lineWeights(d, krigingBlur));
  return weights;
}

/// Measures all candidates again. krigingBlur: in slice distances.
void simulate(Simulation& s, double krigingBlur, std::span<const LineWeights> weights) {
  s.plain = s.projected = s.heldOut = {};
  s.slopeSum = 0;
  s.slopes = 0;
  for (std::size_t axis = 0; axis < s.images.size(); ++axis) {
    const Degraded& d = s.images[axis];
    addErrors(d, weights[axis], s.plain, s.projected);
    s.heldOut.add(heldOutErrors(d.low, d.view, krigingBlur));
    const double slope = slopeShare(d.low);
    s.slopeSum += slope;
    s.slopes += slope > 0;
  }
}

/// How far a simulation is from what the scan shows.
double misfit(const Simulation& s, const Errors& heldOut, double slope) {
  double sum = 0;
  const Covariance<kCandidates> a = s.heldOut.mean(), b = heldOut.mean();
  for (int c = 1; c < kClassical; ++c)
    if (a[0][0] > 0 && b[0][0] > 0 && a[c][c] > 0 && b[c][c] > 0)
      sum += std::abs(std::log(a[c][c] / a[0][0]) - std::log(b[c][c] / b[0][0]));
  if (slope > 0 && s.slope() > 0) sum += std::abs(std::log(s.slope() / slope));
  // Only a hint: contrast along the slices differs from that across them.
  if (a[0][0] > 0 && b[0][0] > 0) sum += kLevel * std::abs(std::log(a[0][0] / b[0][0]));
  return sum;
}

/// The covariance on held-out slices, converted by the simulation from twice the slice distance to the
/// distance itself.
Covariance<kCandidates> calibrated(const Covariance<kCandidates>& heldOut,
                                   const Covariance<kCandidates>& near, const Covariance<kCandidates>& far) {
  Covariance<kCandidates> result = heldOut;
  for (int a = 0; a < kCandidates; ++a)
    for (int b = 0; b < kCandidates; ++b)
      result[a][b] *= std::sqrt(near[a][a] / far[a][a] * near[b][b] / far[b][b]);
  return result;
}

/// Every way to divide kSteps among the guesses from `at` on.
template <std::size_t N>
void addShares(std::array<double, N> share, std::size_t at, int left,
               std::vector<std::array<double, N>>& all) {
  if (at + 1 == N) {
    share[at] = left / double(kSteps);
    all.push_back(share);
    return;
  }
  for (int n = 0; n <= left; ++n) {
    share[at] = n / double(kSteps);
    addShares(share, at + 1, left - n, all);
  }
}

} // namespace

template <std::size_t N>
std::array<double, N> convexShares(std::span<const Covariance<N>> cases) {
  std::vector<std::array<double, N>> tried;
  addShares<N>({}, 0, kSteps, tried);
  std::vector<double> best(cases.size(), std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; n < cases.size(); ++n)
    for (const auto& share : tried)
      best[n] = std::min(best[n], meanSquare(cases[n], share));
  std::array<double, N> chosen{0, 1};
  double least = std::numeric_limits<double>::infinity();
  for (const auto& share : tried) {
    double worst = 0;
    for (std::size_t n = 0; n < cases.size(); ++n)
      worst = std::max(worst, best[n] > 0 ? meanSquare(cases[n], share) / best[n] : 1);
    if (worst >= least) continue;
    least = worst;
    chosen = share;
  }
  return chosen;
}
template std::array<double, 3> convexShares(std::span<const Covariance<3>>);
template std::array<double, 4> convexShares(std::span<const Covariance<4>>);

namespace {

std::array<double, kCandidates> rootsOf(const Covariance<kCandidates>& errors) {
  std::array<double, kCandidates> roots;
  for (int c = 0; c < kCandidates; ++c)
    roots[c] = std::sqrt(errors[c][c]);
  return roots;
}

/// The images along both in-plane axes, blurred by `blur` mm; along only one if just its pixels are finer
/// than the slices' distance.
Simulation simulationOf(const Lines (&within)[2], const Stack& stack, double blur) {
  Simulation result;
  result.blur = blur;
  const auto& spacing = stack.image.geometry.spacing;
  const auto fine = [&](int axis) { return spacing[2] >= kFine * spacing[axis]; };
  for (int axis = 0; axis < 2; ++axis)
    if (fine(axis) || !fine(1 - axis)) degrade(within[axis], stack, spacing[axis], result);
  return result;
}

/// The kriging's blur, in slice distances, that gains most over the best classical candidate, in the weighted
/// mean of the simulations, in dB.
double bestKrigingBlur(std::span<const Simulation> simulations, ThreadPool& pool) {
  constexpr auto k = static_cast<std::size_t>(Candidate::Kriging);
  const std::size_t blurs = std::size(kKrigingBlurs), axes = simulations.front().images.size();
  struct Pair {
    Errors plain, projected;
  };
  std::vector<std::vector<Pair>> errors(blurs * axes, std::vector<Pair>(simulations.size()));
  pool.run(static_cast<std::int64_t>(errors.size()), [&](std::int64_t n) {
    const std::size_t axis = n % axes;
    const Degraded& any = simulations.front().images[axis]; // the geometry is that of all
    const LineWeights weights = lineWeights(any, kKrigingBlurs[n / axes], static_cast<int>(k));
    for (std::size_t s = 0; s < simulations.size(); ++s)
      addErrors(simulations[s].images[axis], weights, errors[n][s].plain, errors[n][s].projected);
  });
  std::vector<double> excess(blurs, 0.0);
  double weights = 0;
  for (std::size_t s = 0; s < simulations.size(); ++s) {
    const Covariance<kCandidates> classical = simulations[s].best().mean();
    weights += simulations[s].weight;
    double least = classical[0][0];
    for (int c = 1; c < kClassical; ++c)
      least = std::min(least, classical[c][c]);
    for (std::size_t blur = 0; blur < blurs && least > 0; ++blur) {
      Pair sum;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        sum.plain.add(errors[blur * axes + axis][s].plain);
        sum.projected.add(errors[blur * axes + axis][s].projected);
      }
      const Errors& best = sum.projected.samples > 0 ? sum.projected : sum.plain;
      excess[blur] += simulations[s].weight * std::log(best.mean()[k][k] / least);
    }
  }
  // Takes the largest of equally good blurs: scans are smoother than slices held out from each other suggest.
  const double enough = *std::min_element(excess.begin(), excess.end()) + weights * std::log(kAsGood);
  std::size_t chosen = excess.size() - 1;
  while (excess[chosen] > enough)
    --chosen;
  return kKrigingBlurs[chosen];
}

} // namespace

CandidateChoice chooseCandidates(const Stack& stack, std::span<const float> complete, ThreadPool& pool) {
  CandidateChoice choice;
  const GridGeometry& g = stack.image.geometry;
  std::vector<std::uint8_t>& inside = choice.inside;
  inside = bodyMask({g, {complete.begin(), complete.end()}}, pool.stopToken());
  for (std::size_t v = 0; v < inside.size(); ++v)
    inside[v] = inside[v] && isKnown(stack, v);
  const Lines across = linesAcross(stack, complete, inside);
  const SliceView view{stack.profile, effectiveThickness(stack) / g.spacing[2]};
  const Lines within[2] = {linesWithin(stack, complete, inside, 0), linesWithin(stack, complete, inside, 1)};
  double slope = 0;
  std::vector<Simulation> simulations(std::size(kBlurs));
  pool.run(static_cast<std::int64_t>(simulations.size()),
           [&](std::int64_t n) { simulations[n] = simulationOf(within, stack, kBlurs[n] * g.spacing[2]); });
  std::vector<LineWeights> weights = weightsOfAxes(simulations.front(), 0);
  Errors heldOut;
  pool.run(static_cast<std::int64_t>(simulations.size()) + 1, [&](std::int64_t n) {
    if (n == 0) {
      heldOut = heldOutErrors(across, view, 0);
      slope = slopeShare(across);
    } else {
      simulate(simulations[n - 1], 0, weights);
    }
  });
  const bool shown = heldOut.samples >= kFewest;
  std::erase_if(simulations, [](const Simulation& s) { return s.plain.samples < kFewest; });
  if (simulations.empty()) {
    if (shown) {
      choice.share = convexShares<kCandidates>(std::vector{heldOut.mean()});
      choice.heldOutError = rootsOf(heldOut.mean());
    }
    return choice;
  }
  if (shown) {
    std::vector<double> misfits;
    for (const Simulation& s : simulations)
      misfits.push_back(misfit(s, heldOut, slope));
    const double least = *std::min_element(misfits.begin(), misfits.end());
    for (std::size_t n = 0; n < simulations.size(); ++n)
      simulations[n].weight = std::exp((least - misfits[n]) / kTemperature);
    std::stable_sort(simulations.begin(), simulations.end(),
                     [](const Simulation& a, const Simulation& b) { return a.weight > b.weight; });
    simulations.resize(std::min<std::size_t>(simulations.size(), kPlausible));
  } else {
    simulations.resize(1);
  }
  const double krigingBlur = bestKrigingBlur(simulations, pool);
  choice.krigingBlur = krigingBlur * g.spacing[2];
  if (krigingBlur > 0) {
    weights = weightsOfAxes(simulations.front(), krigingBlur);
    pool.run(static_cast<std::int64_t>(simulations.size()) + 1, [&](std::int64_t n) {
      if (n == 0)
        heldOut = heldOutErrors(across, view, krigingBlur);
      else
        simulate(simulations[n - 1], krigingBlur, weights);
    });
  }
  if (shown) choice.heldOutError = rootsOf(heldOut.mean());
  const Simulation& nearest = simulations.front();
  choice.judged = true;
  choice.blur = nearest.blur / std::min(g.spacing[0], g.spacing[1]);
  choice.backProject = nearest.projected.samples > 0;
  std::vector<Covariance<kCandidates>> cases;
  for (const Simulation& s : simulations) {
    const Covariance<kCandidates> near = s.best().mean();
    cases.push_back(near);
    if (shown && s.heldOut.samples >= kFewest)
      cases.push_back(calibrated(heldOut.mean(), near, s.heldOut.mean()));
  }
  choice.share = convexShares<kCandidates>(cases);
  const Covariance<kCandidates> pairs = nearest.best().mean();
  choice.pairError = rootsOf(pairs);
  choice.error = std::sqrt(std::max(0.0, meanSquare(pairs, choice.share)));
  const Covariance<kCandidates> far = nearest.heldOut.mean();
  if (far[0][0] > 0 && meanSquare(far, choice.share) > 0) {
    choice.linearFall = std::sqrt(pairs[0][0] / far[0][0]);
    choice.fall = std::sqrt(meanSquare(pairs, choice.share) / meanSquare(far, choice.share));
  }
  return choice;
}

} // namespace innergs
