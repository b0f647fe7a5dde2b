#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Prediction/DenseLayer.h"

#include <array>
#include <functional>
#include <span>

namespace innergs {

/// Turns a latent back into a teacher's embedding: a perceptron with one hidden layer of rectifiers.
struct EmbeddingDecoder {
  static constexpr int kHidden = 64;

  int channels = 16; // of a latent: 16 or 32
  int size = 0;      // numbers of an embedding
  std::vector<float> parameters;

  int stride() const { return (size + 15) / 16 * 16; } // of an embedding in memory; the rest is 0
  std::array<DenseLayer, 2> layers() const;

  /// latents: [sample][channel]; out: [sample][stride()]. `hidden`: scratch.
  void decode(const float* latents, std::int64_t samples, const NetworkKernels& kernels,
              std::vector<float>& hidden, float* out) const;
};

/// Throws Error(FileFormat) for a decoder that cannot be evaluated.
void checkDecoder(const EmbeddingDecoder& decoder);

/// A scene's own compression of a teacher's embeddings to latents and back (LangSplat, Qin et al. 2024,
/// section 3.3), a perceptron with one hidden layer either way.
struct FeatureAutoencoder {
  EmbeddingDecoder decoder;
  std::vector<float> encoder; // parameters

  std::array<DenseLayer, 2> encoderLayers() const;

  /// embeddings: [sample][decoder.stride()]; out: [sample][channel].
  void encode(const float* embeddings, std::int64_t samples, const NetworkKernels& kernels,
              std::vector<float>& hidden, float* out) const;
};

struct AutoencoderTraining {
  int channels = 16;
  int steps = 3000, batch = 256; // of Adam; samples each
  double rate = 2e-3;            // falls to 0
  std::uint64_t seed = 1;
};

/// Σ over samples of |x̂ − x|² + 1 − cos(x̂, x), x: [sample][stride], unit vectors. Adds the gradients of both
/// halves.
double autoencoderLoss(const FeatureAutoencoder& autoencoder, const float* x, std::int64_t samples,
                       const NetworkKernels& kernels, std::span<float> encoderGradient,
                       std::span<float> decoderGradient);

/// Learns from samples [sample][size] of unit length, in batches drawn at random. Bit-identical at any number
/// of threads. Throws Error(Cancelled) when the pool is stopped.
FeatureAutoencoder trainAutoencoder(const std::vector<float>& samples, int size,
                                    const AutoencoderTraining& training, const NetworkKernels& kernels,
                                    ThreadPool& pool, const std::function<void(double)>& progress);

} // namespace innergs
