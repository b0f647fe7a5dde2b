#include "Core/Features/FeatureAutoencoder.h"

#include "Core/Base/Error.h"
#include "Core/Prediction/ParameterAdam.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr int kHidden = EmbeddingDecoder::kHidden;
constexpr std::int64_t kPart = 64; // samples of a batch whose gradient one task sums

std::array<DenseLayer, 2> twoLayers(int inputs, int outputs) {
  const DenseLayer first{0, inputs, kHidden, true};
  return {first, DenseLayer{first.end(), kHidden, outputs, false}};
}

} // namespace

std::array<DenseLayer, 2> EmbeddingDecoder::layers() const {
  return twoLayers(channels, stride());
}

void EmbeddingDecoder::decode(const float* latents, std::int64_t samples, const NetworkKernels& kernels,
                              std::vector<float>& hidden, float* out) const {
  const auto [first, second] = layers();
  hidden.resize(static_cast<std::size_t>(samples) * kHidden);
  first.forward(parameters.data(), latents, samples, kernels, hidden.data());
  second.forward(parameters.data(), hidden.data(), samples, kernels, out);
}

void checkDecoder(const EmbeddingDecoder& decoder) {
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The model's features cannot be used: " + what);
  };
  if (decoder.channels != 16 && decoder.channels != 32) fail("a latent of embeddings has 16 or 32 channels.");
  if (decoder.size < 1 || decoder.size > 65536) fail("an embedding has no numbers or too many.");
  if (decoder.parameters.size() != decoder.layers()[1].end())
    fail("their decoder differs in size from what it says.");
  if (!std::all_of(decoder.parameters.begin(), decoder.parameters.end(),
                   [](float x) { return std::fabs(x) <= 1e9f; }))
    fail("their decoder is not finite.");
}

std::array<DenseLayer, 2> FeatureAutoencoder::encoderLayers() const {
  return twoLayers(decoder.stride(), decoder.channels);
}

void FeatureAutoencoder::encode(const float* embeddings, std::int64_t samples, const NetworkKernels& kernels,
                                std::vector<float>& hidden, float* out) const {
  const auto [first, second] = encoderLayers();
  hidden.resize(static_cast<std::size_t>(samples) * kHidden);
  first.forward(encoder.data(), embeddings, samples, kernels, hidden.data());
  second.forward(encoder.data(), hidden.data(), samples, kernels, out);
}

double autoencoderLoss(const FeatureAutoencoder& a, const float* x, std::int64_t samples,
                       const NetworkKernels& kernels, std::span<float> encoderGradient,
                       std::span<float> decoderGradient) {
  const int size = a.decoder.size, stride = a.decoder.stride(), channels = a.decoder.channels;
  const auto [down, latent] = a.encoderLayers();
  const auto [up, last] = a.decoder.layers();
  const auto count = static_cast<std::size_t>(samples);
  std::vector<float> h1(count * kHidden), z(count * channels), h2(h1.size()), y(count * stride),
      g(y.size(), 0.f), g2(h1.size()), gz(z.size());
  down.forward(a.encoder.data(), x, samples, kernels, h1.data());
  latent.forward(a.encoder.data(), h1.data(), samples, kernels, z.data());
  up.forward(a.decoder.parameters.data(), z.data(), samples, kernels, h2.data());
  last.forward(a.decoder.parameters.data(), h2.data(), samples, kernels, y.data());
  double loss = 0;
  for (std::size_t s = 0; s < count; ++s) {
    const float *truth = x + s * stride, *guess = y.data() + s * stride;
    double dot = 0, square = 0, squared = 0;
    for (int c = 0; c < size; ++c) {
      const double t = truth[c], e = guess[c];
      dot += t * e;
      square += e * e;
      squared += (e - t) * (e - t);
    }
    const double length = std::sqrt(square) + 1e-6, cosine = dot / length;
    loss += squared + 1 - cosine;
    for (int c = 0; c < size; ++c) {
      const double t = truth[c], e = guess[c];
      g[s * stride + c] = static_cast<float>(2 * (e - t) - t / length + cosine * e / (length * length));
    }
  }
  const float *encoder = a.encoder.data(), *decoder = a.decoder.parameters.data();
  last.backward(h2.data(), y.data(), samples, last.transposed(decoder), kernels, g.data(),
                decoderGradient.data(), g2.data());
  up.backward(z.data(), h2.data(), samples, up.transposed(decoder), kernels, g2.data(),
              decoderGradient.data(), gz.data());
  latent.backward(h1.data(), z.data(), samples, latent.transposed(encoder), kernels, gz.data(),
                  encoderGradient.data(), g2.data());
  down.backward(x, h1.data(), samples, {}, kernels, g2.data(), encoderGradient.data(), nullptr);
  return loss;
}

FeatureAutoencoder trainAutoencoder(const std::vector<float>& samples, int size,
                                    const AutoencoderTraining& training, const NetworkKernels& kernels,
                                    ThreadPool& pool, const std::function<void(double)>& progress) {
  FeatureAutoencoder a;
  a.decoder.channels = training.channels;
  a.decoder.size = size;
  Random random(training.seed);
  a.encoder.resize(a.encoderLayers()[1].end());
  a.decoder.parameters.resize(a.decoder.layers()[1].end());
  for (const DenseLayer& layer : a.encoderLayers())
    layer.draw(a.encoder.data(), random);
  for (const DenseLayer& layer : a.decoder.layers())
    layer.draw(a.decoder.parameters.data(), random);
  const int stride = a.decoder.stride();
  const auto count = samples.size() / static_cast<std::size_t>(size);
  const std::int64_t parts = (training.batch + kPart - 1) / kPart;
  struct Part {
    std::vector<float> x, encoder, decoder;
  };
  std::vector<Part> work(static_cast<std::size_t>(parts));
  ParameterAdam encoderAdam(a.encoder.size()), decoderAdam(a.decoder.parameters.size());
  for (int step = 0; step < training.steps; ++step) {
    for (Part& part : work) {
      part.x.assign(static_cast<std::size_t>(kPart * stride), 0.f);
      for (std::int64_t s = 0; s < kPart; ++s)
        std::copy_n(samples.data() + static_cast<std::size_t>(random.next() % count) * size, size,
                    part.x.data() + s * stride);
    }
    pool.run(parts, [&](std::int64_t p) {
      Part& part = work[static_cast<std::size_t>(p)];
      part.encoder.assign(a.encoder.size(), 0.f);
      part.decoder.assign(a.decoder.parameters.size(), 0.f);
      autoencoderLoss(a, part.x.data(), kPart, kernels, part.encoder, part.decoder);
    });
    Part& sum = work.front();
    const float scale = 1 / static_cast<float>(parts * kPart);
    const auto add = [&](std::vector<float> Part::*which) {
      for (std::size_t p = 1; p < work.size(); ++p)
        for (std::size_t i = 0; i < (sum.*which).size(); ++i)
          (sum.*which)[i] += (work[p].*which)[i];
      for (float& g : sum.*which)
        g *= scale;
    };
    add(&Part::encoder);
    add(&Part::decoder);
    const double rate =
        training.rate * 0.5 * (1 + std::cos(std::numbers::pi * (step + 0.5) / training.steps));
    encoderAdam.apply(a.encoder, sum.encoder, rate, kernels);
    decoderAdam.apply(a.decoder.parameters, sum.decoder, rate, kernels);
    if (progress && step % 16 == 15) progress((step + 1.0) / training.steps);
  }
  return a;
}

} // namespace innergs
