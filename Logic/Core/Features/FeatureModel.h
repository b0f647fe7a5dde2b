#pragma once
#include "Core/Features/ClassResidual.h"
#include "Core/Features/FeatureAutoencoder.h"
#include "Core/Features/FeatureStep.h"
#include "Core/Features/IntensityScale.h"
#include "Core/Image/GridGeometry.h"
#include "Core/Model/GaussianField.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace innergs {

/// Which classes occur where: a set of classes per block of a coarse grid. Only those are decoded there.
struct ClassSupport {
  GridGeometry blocks;             // LPS mm; one voxel is one block
  int words = 0;                   // of 32 bits per block
  std::vector<std::uint32_t> bits; // [block][word], bit c % 32 of word c / 32: class c

  bool has(std::int64_t block, int c) const {
    return bits[static_cast<std::size_t>(block * words + c / 32)] >> (c % 32) & 1;
  }
};

/// The features of a field's Gaussians beyond intensity: a latent for each, and the decoder to classes. At a
/// point, F = Σ w p f / (Σ w p + ε), and a class's logit is F·(a + b T₁(u) + c T₂(u)): a, b, c are the
/// class's code, T Chebyshev polynomials, u = 2·rank − 1 of the field's own intensity there. Class 0 is the
/// background. Features of a dense teacher have no codes: F is decoded to an embedding, and a class's logit
/// is kSharpness times the cosine between that and the class's own.
struct FeatureModel {
  static constexpr int kTerms = DecoderTerms::kCount; // vectors of a class's code
  static constexpr float kSharpness = 100.f;          // as CLIP's (Radford et al. 2021)

  int channels = 16;                 // 8, 16 or 32
  std::vector<float> latents;        // [Gaussian][channel]
  std::vector<std::string> names;    // per class
  std::vector<std::uint16_t> labels; // per class: its value in labelmaps
  std::vector<float> codes;          // [class][term][channel]
  IntensityScale scale;
  ClassSupport support;
  ClassResidual residual; // of labels; empty: none
  double time = 0;        // s; of a dynamic model: the time that its labels belong to

  std::optional<EmbeddingDecoder> decoder; // of a dense teacher's features
  std::vector<float> embeddings;           // [class][decoder->size], of unit length; 0 for a background that
                                           // no text stands for

  int classes() const { return static_cast<int>(names.size()); }
  const float* codeOf(int c) const { return codes.data() + static_cast<std::size_t>(c) * kTerms * channels; }
};

/// Bytes of latents, codes, embeddings and support.
std::size_t memoryOf(const FeatureModel& features);

/// Throws Error(FileFormat) if features do not match the field or cannot be evaluated.
void checkFeatures(const FeatureModel& features, const GaussianField& field);

} // namespace innergs
