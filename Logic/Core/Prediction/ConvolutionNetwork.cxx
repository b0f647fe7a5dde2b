#include "Core/Prediction/ConvolutionNetwork.h"

#include "Core/Base/Random.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr float kLeak = 0.1f; // slope of the rectifier below 0; with 0, channels died in training
constexpr int kTaps = 3;      // of a convolution, along each axis
constexpr int kPatch = PatchFeatures::stride;

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

double ConvolutionNetwork::productsPerSample(const Shape& shape) {
  const double convolved =
      kTaps * kTaps * shape.channels * (shape.layers * shape.channels + outputStride(shape.phases));
  return kPatch * shape.channels + convolved * WinogradConvolution::productShare;
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

void ConvolutionNetwork::transform(std::size_t matrix, Transforms& transforms) const {
  if (matrix == 0) return;
  const int layer = static_cast<int>(matrix), channels = shape_.channels, outputs = outputsOf(layer);
  const float* weights = parameters_.data() + layerWeights(layer);
  transforms.forward[matrix - 1] = WinogradConvolution::transformed(weights, channels, outputs);
  std::vector<float> transposed(static_cast<std::size_t>(kTaps * kTaps) * channels * outputs);
  for (int tap = 0; tap < kTaps * kTaps; ++tap)
    for (int i = 0; i < channels; ++i)
      for (int o = 0; o < outputs; ++o)
        transposed[((kTaps * kTaps - 1 - tap) * outputs + o) * channels + i] =
            weights[(tap * channels + i) * outputs + o];
  transforms.backward[matrix - 1] = WinogradConvolution::transformed(transposed.data(), outputs, channels);
}

ConvolutionNetwork::Transforms ConvolutionNetwork::transforms() const {
  const std::size_t layers = static_cast<std::size_t>(shape_.layers) + 1;
  Transforms all{std::vector<std::vector<float>>(layers), std::vector<std::vector<float>>(layers)};
  for (std::size_t matrix = 1; matrix <= layers; ++matrix)
    transform(matrix, all);
  return all;
}

void ConvolutionNetwork::forward(const PatchFeatures& features, const Transforms& transforms,
                                 const NetworkKernels& kernels, Workspace& work) const {
  const BorderedImage image{features.slices, features.columns, shape_.channels};
  if (work.image != image || work.activations.size() != static_cast<std::size_t>(shape_.layers) + 1)
    work.activations.assign(static_cast<std::size_t>(shape_.layers) + 1,
                            std::vector<float>(image.size(), 0.f));
  work.image = image;
  const float* p = parameters_.data();
  float* first = work.activations[0].data() + image.row(0);
  features.forComputed([&](std::int64_t at, std::int64_t count) {
    float* here = first + at * shape_.channels;
    kernels.multiply({.rows = count,
                      .depth = PatchFeatures::count,
                      .columns = shape_.channels,
                      .a = features.values.data() + at * kPatch,
                      .rowStep = kPatch,
                      .b = p + firstWeights(),
                      .c = here,
                      .add = false});
    kernels.activate(count, shape_.channels, p + firstBias(), kLeak, here);
  });
  for (int s = 0; s < features.slices; ++s)
    clearOutside(image, features.spans.empty() ? ColumnSpan{0, features.columns} : features.spans[s],
                 first + s * image.width() * shape_.channels);
  const int last = shape_.layers + 1;
  work.outputs.resize(static_cast<std::size_t>(features.samples()) * outputsOf(last));
  for (int layer = 1; layer <= last; ++layer)
    work.convolution.convolve(
        image, work.activations[layer - 1].data(), transforms.forward[layer - 1], outputsOf(layer),
        features.spans, p + layerBias(layer), layer < last ? kLeak : 1, kernels,
        layer < last ? work.activations[layer].data() + image.row(0) : work.outputs.data());
}

void ConvolutionNetwork::backward(const PatchFeatures& features, const std::vector<float>& outputGradient,
                                  const Transforms& transforms, const NetworkKernels& kernels,
                                  Workspace& work, std::vector<float>& gradient) const {
  const BorderedImage& image = work.image;
  const int last = shape_.layers + 1;
  const std::vector<float> noBias(static_cast<std::size_t>(shape_.channels), 0.f);
  // The gradient with respect to a layer's outputs.
  BorderedImage outer{image.rows, image.columns, outputsOf(last)};
  work.gradient.assign(outer.size(), 0.f);
  std::copy(outputGradient.begin(), outputGradient.end(), work.gradient.begin() + outer.row(0));
  for (int layer = last; layer >= 0; --layer, outer = image) {
    const float* by = work.gradient.data() + outer.row(0);
    kernels.addSums(features.samples(), outer.channels, by,
                    gradient.data() + (layer == 0 ? firstBias() : layerBias(layer)));
    if (layer == 0) {
      kernels.multiply({PatchFeatures::count, features.samples(), shape_.channels, features.values.data(), 1,
                        kPatch, by, gradient.data() + firstWeights()});
      break;
    }
    const std::vector<float>& input = work.activations[layer - 1];
    work.convolution.addWeightGradient(image, input.data(), outer.channels, work.gradient.data(), kernels,
                                       gradient.data() + layerWeights(layer));
    if (work.previous.size() != image.size()) work.previous.assign(image.size(), 0.f);
    float* in = work.previous.data() + image.row(0);
    work.convolution.convolve(outer, work.gradient.data(), transforms.backward[layer - 1], image.channels, {},
                              noBias.data(), 1, kernels, in);
    kernels.activateBack(features.samples(), image.channels, input.data() + image.row(0), kLeak, in);
    work.gradient.swap(work.previous);
  }
}

} // namespace innergs
