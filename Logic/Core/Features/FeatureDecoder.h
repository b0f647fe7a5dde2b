#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/FeatureStep.h"

#include <algorithm>
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
