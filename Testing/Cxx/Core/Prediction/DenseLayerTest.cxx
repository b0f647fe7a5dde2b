#include "Core/Prediction/DenseLayer.h"

#include <gtest/gtest.h>

using namespace innergs;

namespace {

struct Case {
  DenseLayer layer{3, 32, 16, true};
  std::vector<float> parameters, x, weights;
  static constexpr std::int64_t samples = 7;

  Case() : parameters(layer.end()) {
    Random random(11);
    layer.draw(parameters.data(), random);
    const auto draw = [&] { return static_cast<float>(2 * random.uniform() - 1); };
    for (std::size_t i = layer.bias(); i < layer.end(); ++i)
      parameters[i] = 0.3F * draw();
    for (std::int64_t i = 0; i < samples * layer.inputs; ++i)
      x.push_back(draw());
    for (std::int64_t i = 0; i < samples * layer.outputs; ++i)
      weights.push_back(draw());
  }
  double loss() const {
    std::vector<float> y(weights.size());
    layer.forward(parameters.data(), x.data(), samples, scalarNetworkKernels(), y.data());
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i)
      sum += static_cast<double>(y[i]) * static_cast<double>(weights[i]);
    return sum;
  }
  double difference(float& value) const {
    const float before = value;
    constexpr float step = 1e-3F;
    value = before + step;
    const double high = loss();
    value = before - step;
    const double low = loss();
    value = before;
    return (high - low) / (2 * static_cast<double>(step));
  }
};

} // namespace

TEST(DenseLayer, GradientIsTheDifferenceQuotient) {
  for (const bool rectified : {false, true}) {
    Case c;
    c.layer.rectified = rectified;
    std::vector<float> y(c.weights.size()), yGradient = c.weights, gradient(c.parameters.size(), 0.F),
                                            xGradient(c.x.size());
    const NetworkKernels kernels = scalarNetworkKernels();
    c.layer.forward(c.parameters.data(), c.x.data(), Case::samples, kernels, y.data());
    c.layer.backward(c.x.data(), y.data(), Case::samples, c.layer.transposed(c.parameters.data()), kernels,
                     yGradient.data(), gradient.data(), xGradient.data());
    for (std::size_t i = 0; i < c.layer.at; ++i)
      EXPECT_EQ(gradient[i], 0); // of others
    for (std::size_t i = c.layer.at; i < c.parameters.size(); i += 5)
      EXPECT_NEAR(gradient[i], c.difference(c.parameters[i]), 2e-3) << i;
    for (std::size_t i = 0; i < c.x.size(); i += 3)
      EXPECT_NEAR(xGradient[i], c.difference(c.x[i]), 2e-3) << i;
  }
}
