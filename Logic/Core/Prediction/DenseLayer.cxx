#include "Core/Prediction/DenseLayer.h"

#include <algorithm>
#include <cmath>

namespace innergs {

void DenseLayer::draw(float* parameters, Random& random) const {
  const double most = std::sqrt(6.0 / static_cast<double>(inputs));
  for (std::size_t i = at; i < bias(); ++i)
    parameters[i] = static_cast<float>(most * (2 * random.uniform() - 1));
  std::fill(parameters + bias(), parameters + end(), 0.f);
}

void DenseLayer::forward(const float* parameters, const float* x, std::int64_t samples,
                         const NetworkKernels& kernels, float* y) const {
  for (std::int64_t s = 0; s < samples; ++s)
    std::copy_n(parameters + bias(), outputs, y + s * outputs);
  kernels.multiply({samples, inputs, outputs, x, inputs, 1, parameters + at, y});
  if (!rectified) return;
  for (std::int64_t i = 0; i < samples * outputs; ++i)
    y[i] = std::max(y[i], 0.f);
}

std::vector<float> DenseLayer::transposed(const float* parameters) const {
  std::vector<float> out(static_cast<std::size_t>(inputs * outputs));
  for (std::int64_t i = 0; i < inputs; ++i)
    for (std::int64_t o = 0; o < outputs; ++o)
      out[o * inputs + i] = parameters[at + i * outputs + o];
  return out;
}

void DenseLayer::backward(const float* x, const float* y, std::int64_t samples,
                          const std::vector<float>& transposed, const NetworkKernels& kernels,
                          float* yGradient, float* gradient, float* xGradient) const {
  if (rectified) kernels.activateBack(samples, static_cast<int>(outputs), y, 0, yGradient);
  kernels.addSums(samples, static_cast<int>(outputs), yGradient, gradient + bias());
  kernels.multiply({inputs, samples, outputs, x, 1, inputs, yGradient, gradient + at});
  if (!xGradient) return;
  kernels.multiply({.rows = samples,
                    .depth = outputs,
                    .columns = inputs,
                    .a = yGradient,
                    .rowStep = outputs,
                    .b = transposed.data(),
                    .c = xGradient,
                    .add = false});
}

} // namespace innergs
