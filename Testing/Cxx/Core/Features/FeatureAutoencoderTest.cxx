#include "Core/Features/FeatureAutoencoder.h"

#include "Core/Base/Error.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

constexpr int kEdge = 21; // not a multiple of a vector

/// Embeddings of unit length in the plane of two directions, [sample][kEdge].
std::vector<float> unitSamples(int count) {
  Random random(3);
  std::vector<float> directions, samples;
  for (int i = 0; i < 2 * kEdge; ++i)
    directions.push_back(static_cast<float>(2 * random.uniform() - 1));
  for (int s = 0; s < count; ++s) {
    const auto a = static_cast<float>(random.uniform()), b = static_cast<float>(random.uniform());
    float square = 0;
    std::vector<float> x;
    for (int i = 0; i < kEdge; ++i) {
      x.push_back(a * directions[i] + b * directions[kEdge + i]);
      square += x.back() * x.back();
    }
    for (const float v : x)
      samples.push_back(v / std::sqrt(square));
  }
  return samples;
}

TEST(FeatureAutoencoder, GradientIsTheDifferenceQuotient) {
  AutoencoderTraining short_;
  short_.steps = 3;
  ThreadPool pool(1);
  const NetworkKernels kernels = scalarNetworkKernels();
  const std::vector<float> samples = unitSamples(40);
  FeatureAutoencoder a = trainAutoencoder(samples, kEdge, short_, kernels, pool, {});
  std::vector<float> x(5 * static_cast<std::size_t>(a.decoder.stride()), 0.f);
  for (int s = 0; s < 5; ++s)
    std::copy_n(samples.data() + static_cast<std::ptrdiff_t>(s) * kEdge, kEdge,
                x.data() + static_cast<std::ptrdiff_t>(s) * a.decoder.stride());
  std::vector<float> encoder(a.encoder.size(), 0.f), decoder(a.decoder.parameters.size(), 0.f);
  autoencoderLoss(a, x.data(), 5, kernels, encoder, decoder);
  const auto loss = [&] {
    std::vector<float> e(encoder.size(), 0.f), d(decoder.size(), 0.f);
    return autoencoderLoss(a, x.data(), 5, kernels, e, d);
  };
  const auto compare = [&](std::vector<float>& parameters, const std::vector<float>& gradient) {
    double difference = 0, size = 0;
    for (std::size_t i = 0; i < parameters.size(); i += 3) {
      const float before = parameters[i];
      constexpr float step = 2e-3F; // a few rectifiers turn within it
      parameters[i] = before + step;
      const double high = loss();
      parameters[i] = before - step;
      const double low = loss();
      parameters[i] = before;
      const double quotient = (high - low) / (2 * static_cast<double>(step));
      difference += std::pow(quotient - static_cast<double>(gradient[i]), 2);
      size += quotient * quotient;
    }
    EXPECT_GT(size, 0);
    EXPECT_LT(std::sqrt(difference / size), 0.02);
  };
  compare(a.encoder, encoder);
  compare(a.decoder.parameters, decoder);
}

TEST(FeatureAutoencoder, RestoresWhatItLearned) {
  ThreadPool pool(2);
  const NetworkKernels& kernels = networkKernels("");
  const std::vector<float> samples = unitSamples(500);
  AutoencoderTraining plan;
  plan.steps = 600;
  const FeatureAutoencoder a = trainAutoencoder(samples, kEdge, plan, kernels, pool, {});
  EXPECT_NO_THROW(checkDecoder(a.decoder));
  std::vector<float> x(static_cast<std::size_t>(a.decoder.stride()), 0.f), latent(16), hidden, y(x.size());
  double worst = 1;
  for (int s = 0; s < 500; ++s) {
    std::copy_n(samples.data() + static_cast<std::ptrdiff_t>(s) * kEdge, kEdge, x.data());
    a.encode(x.data(), 1, kernels, hidden, latent.data());
    a.decoder.decode(latent.data(), 1, kernels, hidden, y.data());
    double dot = 0, square = 0;
    for (int i = 0; i < kEdge; ++i) {
      dot += static_cast<double>(x[i]) * static_cast<double>(y[i]);
      square += static_cast<double>(y[i]) * static_cast<double>(y[i]);
    }
    worst = std::min(worst, dot / std::sqrt(square));
  }
  EXPECT_GT(worst, 0.99);
}

TEST(FeatureAutoencoder, SameBitsAtAnyNumberOfThreadsAndStops) {
  AutoencoderTraining plan;
  plan.steps = 10;
  const std::vector<float> samples = unitSamples(50);
  ThreadPool one(1), four(4);
  const FeatureAutoencoder a = trainAutoencoder(samples, kEdge, plan, networkKernels(""), one, {}),
                           b = trainAutoencoder(samples, kEdge, plan, networkKernels(""), four, {});
  EXPECT_EQ(a.encoder, b.encoder);
  EXPECT_EQ(a.decoder.parameters, b.decoder.parameters);
  std::stop_source stop;
  stop.request_stop();
  four.setStop(stop.get_token());
  EXPECT_THROW(trainAutoencoder(samples, kEdge, plan, networkKernels(""), four, {}), Error);
}

} // namespace
} // namespace innergs::testing
