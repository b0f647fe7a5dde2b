#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/FeatureStep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace innergs {

/// Probabilities (softmax of the logits) of some classes, from a latent F of N channels.
template <int N>
void decode(const FeatureModel& model, const float* latent, float rank,
            std::span<const std::uint16_t> classes, float* probabilities) {
  const DecoderTerms terms(rank);
  float greatest = -INFINITY;
  for (std::size_t n = 0; n < classes.size(); ++n) {
    const float* code = model.codeOf(classes[n]);
    float logit = 0;
    for (int t = 0; t < FeatureModel::kTerms; ++t, code += N) {
      float sum = 0;
      for (int channel = 0; channel < N; ++channel)
        sum += latent[channel] * code[channel];
      logit += terms.v[t] * sum;
    }
    probabilities[n] = logit;
    greatest = std::max(greatest, logit);
  }
  float sum = 0;
  for (std::size_t n = 0; n < classes.size(); ++n)
    sum += probabilities[n] = std::exp(probabilities[n] - greatest);
  for (std::size_t n = 0; n < classes.size(); ++n)
    probabilities[n] /= sum;
}

/// Adds ∂L/∂F to `gradient` and ∂L/∂code to `codeGradient` (shaped like model.codes; null: skipped), given
/// ∂L/∂logit of the classes: for the cross-entropy, the probability minus the target.
template <int N>
void decodeBackward(const FeatureModel& model, const float* latent, float rank,
                    std::span<const std::uint16_t> classes, const float* logitGradient, float* gradient,
                    float* codeGradient = nullptr) {
  const DecoderTerms terms(rank);
  for (std::size_t n = 0; n < classes.size(); ++n) {
    const float* code = model.codeOf(classes[n]);
    for (int t = 0; t < FeatureModel::kTerms; ++t, code += N) {
      const float r = terms.v[t] * logitGradient[n];
      for (int channel = 0; channel < N; ++channel)
        gradient[channel] += r * code[channel];
      if (!codeGradient) continue;
      float* into = codeGradient + (code - model.codes.data());
      for (int channel = 0; channel < N; ++channel)
        into[channel] += r * latent[channel];
    }
  }
}

/// The classes of each block, as lists.
class SupportLists {
public:
  explicit SupportLists(const ClassSupport& support) {
    const std::int64_t blocks = support.blocks.voxelCount();
    start_.push_back(0);
    for (std::int64_t b = 0; b < blocks; ++b) {
      for (int c = 0; c < 32 * support.words; ++c)
        if (support.has(b, c)) classes_.push_back(static_cast<std::uint16_t>(c));
      most_ = std::max(most_, classes_.size() - start_.back());
      start_.push_back(classes_.size());
    }
  }
  std::span<const std::uint16_t> of(std::int64_t block) const {
    const auto b = static_cast<std::size_t>(block);
    return {classes_.data() + start_[b], start_[b + 1] - start_[b]};
  }
  std::size_t longest() const { return most_; }
  std::int64_t blocks() const { return static_cast<std::int64_t>(start_.size()) - 1; }

private:
  std::vector<std::uint16_t> classes_;
  std::vector<std::size_t> start_;
  std::size_t most_ = 0;
};

/// Finds the block that contains a point, from the indices of a lattice; −1 outside.
class BlockFinder {
public:
  BlockFinder(const GridGeometry& blocks, const Affine3& indexToWorld)
      : size_(blocks.size), map_(inverse(blocks.indexToWorld()) * indexToWorld) {}
  std::int64_t operator()(const Vec3& index) const {
    const Vec3 x = map_(index);
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      if (!(x[a] >= -0.5 && x[a] < static_cast<double>(size_[a]) - 0.5)) return -1;
      at[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x[a] + 0.5)), 0, size_[a] - 1);
    }
    return at[0] + size_[0] * (at[1] + size_[1] * at[2]);
  }

private:
  std::array<std::int64_t, 3> size_;
  Affine3 map_;
};

/// Calls action<N>() with the number of channels as a constant.
template <class Action>
void withChannels(int channels, Action&& action) {
  if (channels == 8)
    action.template operator()<8>();
  else if (channels == 32)
    action.template operator()<32>();
  else
    action.template operator()<16>();
}

} // namespace innergs
