#include "Core/Prediction/ConvolutionNetwork.h"

#include "Core/Base/Random.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr float kLeak = 0.1f; // slope of the rectifier below 0; with 0, channels died in training
constexpr int kTaps = 3;      // of a convolution, along each axis
constexpr int kPatch = PatchFeatures::stride;

/// Images with a border of zeros: rows of `width` samples (a border column at each end), one row above and
/// one below, and one sample before and after all.
struct Bordered {
  std::int64_t width, samples; // of the image, including border columns
  int channels;

  Bordered(const PatchFeatures& features, int imageChannels)
      : width(features.paddedColumns()), samples(features.samples()), channels(imageChannels) {}
  std::size_t size() const { return static_cast<std::size_t>((samples + 2 * width + 2) * channels); }
  std::int64_t first() const { return (width + 1) * channels; } // index of the image's first sample
  /// Where the first sample's neighbourhood starts in a row of taps.
  std::int64_t tapRow(int row) const { return first() + ((row - kTaps / 2) * width - kTaps / 2) * channels; }
};

void fillBias(float* image, std::int64_t samples, int channels, const float* bias) {
  for (std::int64_t s = 0; s < samples; ++s)
    std::copy_n(bias, channels, image + s * channels);
}

void clearBorders(float* image, std::int64_t rows, std::int64_t width, int channels) {
  for (std::int64_t r = 0; r < rows; ++r) {
    std::fill_n(image + r * width * channels, channels, 0.f);
    std::fill_n(image + ((r + 1) * width - 1) * channels, channels, 0.f);
  }
}

void rectify(float* values, std::int64_t count) {
  for (std::int64_t i = 0; i < count; ++i)
    values[i] = std::max(values[i], kLeak * values[i]); // no branch: random signs would defeat its prediction
}

void rectifyBack(const float* activation, float* gradient, std::int64_t count) {
  for (std::int64_t i = 0; i < count; ++i)
    gradient[i] *= activation[i] > 0 ? 1.0f : kLeak;
}

void addSums(const float* image, std::int64_t samples, int channels, float* sums) {
  // Sums that may alias the image would stay in memory; channels are a multiple of 16.
  constexpr int lanes = 16;
  for (int c = 0; c < channels; c += lanes) {
    float sum[lanes] = {};
    for (std::int64_t s = 0; s < samples; ++s)
      for (int l = 0; l < lanes; ++l)
        sum[l] += image[s * channels + c + l];
    for (int l = 0; l < lanes; ++l)
      sums[c + l] += sum[l];
  }
}

/// Computes `count` samples from sample `at` on; out: of all samples.
void convolve(const Bordered& in, const float* image, const float* weights, int outputs, std::int64_t at,
              std::int64_t count, const MatrixKernels& kernels, float* out) {
  for (int row = 0; row < kTaps; ++row)
    kernels.multiplyAdd(
        {count, kTaps * in.channels, outputs, image + in.tapRow(row) + at * in.channels, in.channels, 1,
         weights + static_cast<std::int64_t>(row) * kTaps * in.channels * outputs, out + at * outputs});
}

} // namespace

ConvolutionNetwork::ConvolutionNetwork(const Shape& shape, std::uint64_t seed) : shape_(shape) {
  const int last = shape.layers + 1;
  parameters_.assign(layerBias(last) + outputsOf(last), 0.f);
  Random random(seed);
  const auto draw = [&](std::size_t at, std::size_t count, double inputs) {
    const double limit = std::sqrt(6 / inputs); // uniform with variance 2 / inputs
    for (std::size_t i = 0; i < count; ++i)
      parameters_[at + i] = static_cast<float>(limit * (2 * random.uniform() - 1));
  };
  const auto channels = static_cast<std::size_t>(shape.channels);
  draw(firstWeights(), PatchFeatures::count * channels, PatchFeatures::count);
  for (int layer = 1; layer < last; ++layer)
    draw(layerWeights(layer), kTaps * kTaps * channels * channels,
         static_cast<double>(kTaps * kTaps * channels));
}

std::size_t ConvolutionNetwork::firstBias() const {
  return static_cast<std::size_t>(kPatch) * shape_.channels;
}

std::size_t ConvolutionNetwork::layerWeights(int layer) const {
  const auto channels = static_cast<std::size_t>(shape_.channels);
  return firstBias() + channels + (layer - 1) * (kTaps * kTaps * channels * channels + channels);
}

int ConvolutionNetwork::outputsOf(int layer) const {
  return layer <= shape_.layers ? shape_.channels : outputStride(shape_.phases);
}

std::size_t ConvolutionNetwork::layerBias(int layer) const {
  return layerWeights(layer) + static_cast<std::size_t>(kTaps * kTaps) * shape_.channels * outputsOf(layer);
}

std::vector<ConvolutionNetwork::Matrix> ConvolutionNetwork::matrices() const {
  std::vector<Matrix> all{{firstWeights(), kPatch, shape_.channels}};
  for (int layer = 1; layer <= shape_.layers + 1; ++layer)
    all.push_back({layerWeights(layer), kTaps * kTaps * shape_.channels, outputsOf(layer)});
  return all;
}

void ConvolutionNetwork::forward(const PatchFeatures& features, const MatrixKernels& kernels,
                                 Workspace& work) const {
  const Bordered image(features, shape_.channels);
  const float* p = parameters_.data();
  work.activations.resize(static_cast<std::size_t>(shape_.layers) + 1);
  for (int layer = 0; layer <= shape_.layers; ++layer) {
    auto& activation = work.activations[layer];
    if (activation.size() != image.size() || !features.spans.empty()) activation.assign(image.size(), 0.f);
    float* out = activation.data() + image.first();
    features.forComputed([&](std::int64_t at, std::int64_t count) {
      float* here = out + at * shape_.channels;
      fillBias(here, count, shape_.channels, p + (layer == 0 ? firstBias() : layerBias(layer)));
      if (layer == 0)
        kernels.multiplyAdd({count, PatchFeatures::count, shape_.channels,
                             features.values.data() + at * kPatch, kPatch, 1, p + firstWeights(), here});
      else
        convolve(image, work.activations[layer - 1].data(), p + layerWeights(layer), shape_.channels, at,
                 count, kernels, out);
      rectify(here, count * shape_.channels);
    });
    clearBorders(out, features.slices, image.width, shape_.channels);
  }
  const int last = shape_.layers + 1, outputs = outputsOf(last);
  work.outputs.resize(static_cast<std::size_t>(image.samples) * outputs);
  features.forComputed([&](std::int64_t at, std::int64_t count) {
    fillBias(work.outputs.data() + at * outputs, count, outputs, p + layerBias(last));
    convolve(image, work.activations[shape_.layers].data(), p + layerWeights(last), outputs, at, count,
             kernels, work.outputs.data());
  });
}

std::vector<float> ConvolutionNetwork::transposedWeights() const {
  std::vector<float> transposed(parameters_.size(), 0.f);
  const int channels = shape_.channels;
  for (int layer = 1; layer <= shape_.layers + 1; ++layer) {
    const int outputs = outputsOf(layer);
    const float* from = parameters_.data() + layerWeights(layer);
    float* to = transposed.data() + layerWeights(layer);
    for (int tap = 0; tap < kTaps * kTaps; ++tap)
      for (int i = 0; i < channels; ++i)
        for (int o = 0; o < outputs; ++o)
          to[((kTaps * kTaps - 1 - tap) * outputs + o) * channels + i] =
              from[(tap * channels + i) * outputs + o];
  }
  return transposed;
}

void ConvolutionNetwork::backward(const PatchFeatures& features, const std::vector<float>& outputGradient,
                                  const std::vector<float>& transposed, const MatrixKernels& kernels,
                                  Workspace& work, std::vector<float>& gradient) const {
  const Bordered image(features, shape_.channels);
  const int last = shape_.layers + 1;
  // The gradient with respect to a layer's outputs, with a border of zeros.
  const Bordered lastImage(features, outputsOf(last));
  work.gradient.assign(lastImage.size(), 0.f);
  std::copy(outputGradient.begin(), outputGradient.end(), work.gradient.begin() + lastImage.first());
  for (int layer = last; layer >= 0; --layer) {
    const Bordered outer(features, outputsOf(layer));
    const float* by = work.gradient.data() + outer.first();
    addSums(by, outer.samples, outer.channels,
            gradient.data() + (layer == 0 ? firstBias() : layerBias(layer)));
    if (layer == 0) {
      kernels.multiplyAdd({PatchFeatures::count, image.samples, shape_.channels, features.values.data(), 1,
                           kPatch, by, gradient.data() + firstWeights()});
      break;
    }
    const float* input = work.activations[layer - 1].data();
    for (int row = 0; row < kTaps; ++row)
      kernels.multiplyAdd({kTaps * image.channels, image.samples, outer.channels, input + image.tapRow(row),
                           1, image.channels, by,
                           gradient.data() + layerWeights(layer) +
                               static_cast<std::size_t>(row) * kTaps * image.channels * outer.channels});
    work.previous.assign(image.size(), 0.f);
    float* in = work.previous.data() + image.first();
    convolve(outer, work.gradient.data(), transposed.data() + layerWeights(layer), shape_.channels, 0,
             image.samples, kernels, in);
    rectifyBack(input + image.first(), in, image.samples * image.channels);
    clearBorders(in, features.slices, image.width, image.channels);
    work.gradient.swap(work.previous);
  }
}

} // namespace innergs
