#include "Core/Prediction/SliceSimulation.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/Observation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr double kFine = 1.5; // minimum slice distance, in pixels
constexpr int kBackProjections = 12;
constexpr float kNegligibleWeight = 1e-6F; // weight of a slice

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

std::vector<double> convolved(std::span<const double> a, std::span<const double> b) {
  std::vector<double> kernel(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      kernel[i + j] += a[i] * b[j];
  return kernel;
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

using Guesses = std::array<std::vector<float>, kCandidates>; // empty: left out

/// counts(row): whether a row of the truth is scored.
template <class Counts>
CandidateErrors errorsOf(const SliceLines& truth, const Guesses& guess, const Counts& counts) {
  CandidateErrors errors;
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

Guesses guessesBy(const Weights& weights, const SliceLines& low) {
  Guesses guess;
  for (int c = 0; c < kCandidates; ++c)
    if (!weights[c].first.empty()) guess[c] = interpolated(low.value, low.width, weights[c]);
  return guess;
}

/// The back-projection step along the axis: x += U S(low − P x), with the weights of spreadingWeights() as S.
void backProjectLines(std::vector<float>& x, const SliceLines& low, std::int64_t length,
                      std::span<const double> profile, std::int64_t factor, std::span<const double> spreading,
                      const SliceWeights& linear) {
  for (int iteration = 0; iteration < kBackProjections; ++iteration) {
    std::vector<float> rest = sampledRows(x, length, low.width, profile, factor);
    for (std::size_t i = 0; i < rest.size(); ++i)
      rest[i] = low.value[i] - rest[i];
    if (spreading.size() > 1) rest = sampledRows(rest, low.length, low.width, spreading);
    const std::vector<float> step = interpolated(rest, low.width, linear);
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += step[i];
  }
}

/// The same interpolation, followed by back-projection.
SliceWeights projected(const SliceWeights& weights, const DegradedImages& d,
                       std::span<const double> spreading, const SliceWeights& linear) {
  const std::int64_t n = d.low.length;
  SliceLines single; // one line per slice, which alone is 1 in it
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

/// Adds the images, unless they are too short.
void degrade(const InPlaneLines& within, const Stack& stack, int axis, SliceSimulation& result) {
  const SliceLines& image = within.image;
  const double sample = stack.image.geometry.spacing[axis];
  const double distance = stack.image.geometry.spacing[2] / sample;
  DegradedImages d;
  d.factor = std::max<std::int64_t>(2, std::llround(distance));
  d.truth = image;
  d.truth.value = sampledRows(image.value, image.length, image.width, gaussianKernel(result.blur / sample));
  d.truth.length = (d.truth.length - 1) / d.factor * d.factor + 1;
  d.truth.value.resize(d.truth.length * d.truth.width);
  d.truth.inside.resize(d.truth.value.size());
  if (d.truth.length < 4 * d.factor) return;
  d.profile = profileKernel(stack, sample);
  d.low = decimated(d.truth, d.factor);
  d.low.value = sampledRows(d.truth.value, d.truth.length, d.truth.width, d.profile, d.factor);
  d.at = positions(d.truth.length, 1.0 / static_cast<double>(d.factor));
  d.view = {d.profile.size() > 1 ? stack.profile : SliceProfile::Point,
            effectiveThickness(stack) / sample / static_cast<double>(d.factor)};
  SliceLines detail = decimated(within.detail, d.factor);
  detail.value = sampledRows(within.detail.value, image.length, image.width,
                             convolved(gaussianKernel(result.blur / sample), d.profile), d.factor);
  result.change[1 - axis] = changeShare(detail);
  result.images.push_back(std::move(d));
}

} // namespace

void CandidateErrors::add(const CandidateErrors& other) {
  for (int a = 0; a < kCandidates; ++a)
    for (int b = 0; b < kCandidates; ++b)
      sum[a][b] += other.sum[a][b];
  samples += other.samples;
}

Covariance<kCandidates> CandidateErrors::mean() const {
  Covariance<kCandidates> mean = sum;
  for (auto& row : mean)
    for (double& x : row)
      x /= static_cast<double>(std::max<std::int64_t>(1, samples));
  return mean;
}

CandidateErrors heldOutErrors(const SliceLines& slices, const SliceView& view, double krigingBlur) {
  // Here the kriging must predict the slices themselves, not the signal that they see.
  const double profileVariance = view.profile == SliceProfile::Point ? 0
                                 : view.profile == SliceProfile::Box
                                     ? view.thickness * view.thickness / 12
                                     : view.thickness * view.thickness / (8 * std::numbers::ln2);
  const double seenBlur = std::sqrt(krigingBlur * krigingBlur + profileVariance);
  CandidateErrors errors;
  for (std::int64_t phase = 0; phase < 2; ++phase) {
    const SliceLines kept = decimated(slices, 2, phase);
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

LineWeights lineWeights(const DegradedImages& d, double krigingBlur, int first) {
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

void addErrors(const DegradedImages& d, const LineWeights& weights, CandidateErrors& plain,
               CandidateErrors& projected) {
  const bool thick = d.profile.size() > 1;
  const auto counts = [&](std::int64_t n) { return thick || n % d.factor != 0; };
  plain.add(errorsOf(d.truth, guessesBy(weights.plain, d.low), counts));
  if (thick) projected.add(errorsOf(d.truth, guessesBy(weights.projected, d.low), counts));
}

std::vector<LineWeights> weightsOfAxes(const SliceSimulation& any, double krigingBlur) {
  std::vector<LineWeights> weights;
  for (const DegradedImages& d : any.images)
    weights.push_back(lineWeights(d, krigingBlur));
  return weights;
}

void measureCandidates(SliceSimulation& s, double krigingBlur, std::span<const LineWeights> weights) {
  s.plain = s.projected = s.heldOut = {};
  s.slopeSum = 0;
  s.slopes = 0;
  for (std::size_t axis = 0; axis < s.images.size(); ++axis) {
    const DegradedImages& d = s.images[axis];
    addErrors(d, weights[axis], s.plain, s.projected);
    s.heldOut.add(heldOutErrors(d.low, d.view, krigingBlur));
    const double slope = slopeShare(d.low);
    s.slopeSum += slope;
    s.slopes += slope > 0;
  }
}

bool isJudgedBy(const GridGeometry& stack, int axis) {
  const auto fine = [&](int a) { return stack.spacing[2] >= kFine * stack.spacing[a]; };
  return fine(axis) || !fine(1 - axis);
}

SliceSimulation simulateSlices(const InPlaneLines (&within)[2], const Stack& stack, double blur) {
  SliceSimulation result;
  result.blur = blur;
  for (int axis = 0; axis < 2; ++axis)
    if (isJudgedBy(stack.image.geometry, axis)) degrade(within[axis], stack, axis, result);
  return result;
}

} // namespace innergs
