#include "Core/Features/FeatureModel.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::size_t memoryOf(const FeatureModel& f) {
  return sizeof(float) * (f.latents.size() + f.codes.size() + f.embeddings.size() + f.support.bits.size());
}

void checkFeatures(const FeatureModel& f, const GaussianField& field) {
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The model's features cannot be used: " + what);
  };
  const auto bounded = [](const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::fabs(x) <= 1e9f; });
  };
  if (f.channels != 8 && f.channels != 16 && f.channels != 32) fail("a latent has 8, 16 or 32 channels.");
  const auto channels = static_cast<std::size_t>(f.channels);
  if (f.names.size() < 2 || f.names.size() > 65535) fail("they name no class.");
  if (f.labels.size() != f.names.size()) fail("they do not have one label per class.");
  if (f.latents.size() != field.gaussians.size() * channels)
    fail("they do not have one latent per Gaussian.");
  if (f.decoder) {
    checkDecoder(*f.decoder);
    if (f.decoder->channels != f.channels) fail("their decoder is for latents of another size.");
    if (f.embeddings.size() != f.names.size() * static_cast<std::size_t>(f.decoder->size))
      fail("they do not have one embedding per class.");
    if (!bounded(f.embeddings)) fail("an embedding is not finite.");
  }
  if (f.codes.size() != (f.decoder ? 0 : f.names.size() * FeatureModel::kTerms * channels))
    fail("they do not have one code per class.");
  if (!bounded(f.latents) || !bounded(f.codes)) fail("a latent or code is not finite.");
  if (f.scale.knots.size() == 1 || !std::is_sorted(f.scale.knots.begin(), f.scale.knots.end()) ||
      !bounded(f.scale.knots) || !bounded({f.scale.low}) ||
      (!f.scale.knots.empty() && f.scale.low > f.scale.knots.front()))
    fail("their intensity scale does not ascend.");
  checkGeometry(f.support.blocks, "The features' grid of blocks");
  if (f.support.words != (f.classes() + 31) / 32 ||
      static_cast<std::int64_t>(f.support.bits.size()) != f.support.blocks.voxelCount() * f.support.words)
    fail("their class support differs in size from what it says.");
  checkResidual(f.residual, f.classes());
  if (!std::isfinite(f.time)) fail("the time of their labels is not finite.");
}

} // namespace innergs
