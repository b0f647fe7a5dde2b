#include "Core/Features/Teacher.h"

namespace innergs {

FeatureModel trainFrom(const GaussianField& field, const Teacher& teacher, const FeatureTraining& training) {
  if (const auto* given = std::get_if<NamedLabels>(&teacher))
    return trainFeatures(field, given->labels, given->names, training);
  const auto& dense = std::get<DenseTeacher>(teacher);
  EmbeddingTraining own;
  own.channels = training.channels;
  own.threads = training.threads;
  own.seed = training.seed;
  own.progress = training.progress;
  own.stop = training.stop;
  return trainEmbeddings(field, dense.features, dense.texts, own);
}

} // namespace innergs
