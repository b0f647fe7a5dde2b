#pragma once
#include "Core/Features/EmbeddingTraining.h"
#include "Core/Features/FeatureTraining.h"

#include <variant>

namespace innergs {

/// Embeddings at every voxel, and what texts mean to the model that made them.
struct DenseTeacher {
  EmbeddingVolume features;
  std::vector<TextEmbedding> texts;
};

/// What a field's features are learned from.
using Teacher = std::variant<NamedLabels, DenseTeacher>;

/// trainFeatures() or trainEmbeddings(), which has iterations of its own.
FeatureModel trainFrom(const GaussianField& field, const Teacher& teacher,
                       const FeatureTraining& training = {});

} // namespace innergs
