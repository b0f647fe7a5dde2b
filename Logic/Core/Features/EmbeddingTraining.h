#pragma once
#include "Core/Features/FeatureModel.h"

#include <functional>
#include <span>
#include <stop_token>

namespace innergs {

/// A dense teacher: an embedding per voxel, such as from a vision-language model.
struct EmbeddingVolume {
  GridGeometry geometry;
  std::vector<std::vector<float>> channels; // [channel][voxel], memory order of Volume; not finite in one or
                                            // 0 in all: no embedding there
};

/// What a text means to the teacher: an embedding of the same size. "background" is everything that
/// is none of the others.
struct TextEmbedding {
  std::string name;
  std::vector<float> values;
};

struct EmbeddingTraining {
  int channels = 16; // of a latent: 16 or 32
  int threads = 0;   // 0 = all cores
  std::uint64_t seed = 1;
  std::function<void(double)> progress; // fraction done
  std::stop_token stop;                 // stopped: throws Error(Cancelled)
};

/// Distils a dense teacher into a field, whose geometry stays as it is: trains an autoencoder on the scene's
/// own embeddings, finds the latents whose F comes nearest to the encoded ones (least squares by conjugate
/// gradients), then refines latents and decoder on embeddingLoss() where classes meet. A class's probability
/// is the softmax of the cosines between its text's embedding and the decoded one, among the classes that the
/// teacher itself sees nearby. Bit-identical at any number of threads. Throws Error(NoData) without an
/// embedding inside the field, Error(InvalidArgument) for texts of another size or if there are none,
/// Error(Geometry | Cancelled).
FeatureModel trainEmbeddings(const GaussianField& field, const EmbeddingVolume& teacher,
                             const std::vector<TextEmbedding>& texts, const EmbeddingTraining& training = {});

/// Cross-entropy of one class among several, from the cosines of a decoded embedding with the classes' own;
/// adds its gradient with respect to the embedding.
double embeddingLoss(const FeatureModel& model, const float* embedding,
                     std::span<const std::uint16_t> classes, int truth, float* gradient);

} // namespace innergs
