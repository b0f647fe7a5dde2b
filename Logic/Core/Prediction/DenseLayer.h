#pragma once
#include "Core/Base/Random.h"
#include "Core/Prediction/NetworkKernels.h"

namespace innergs {

/// A fully connected layer, y = xW + b or max(0, xW + b): where it lies among a network's parameters, the
/// weights [input][output] first, then the biases.
struct DenseLayer {
  std::size_t at = 0;
  std::int64_t inputs = 0, outputs = 0; // outputs: a multiple of 16
  bool rectified = false;

  std::size_t bias() const { return at + static_cast<std::size_t>(inputs * outputs); }
  std::size_t end() const { return bias() + static_cast<std::size_t>(outputs); }

  /// Uniform weights of variance 2 / inputs (He et al. 2015), no biases.
  void draw(float* parameters, Random& random) const;

  /// x: [sample][input], y: [sample][output].
  void forward(const float* parameters, const float* x, std::int64_t samples, const NetworkKernels& kernels,
               float* y) const;

  /// The weights as backward() needs them.
  std::vector<float> transposed(const float* parameters) const;

  /// Given the gradient of y, which the rectifier changes in place, adds that of the parameters, laid out as
  /// they are, and writes that of x unless null (inputs: a multiple of 16). y may be null without a
  /// rectifier.
  void backward(const float* x, const float* y, std::int64_t samples, const std::vector<float>& transposed,
                const NetworkKernels& kernels, float* yGradient, float* gradient, float* xGradient) const;
};

} // namespace innergs
