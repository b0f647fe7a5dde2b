#pragma once
#include "Core/Prediction/NetworkKernels.h"

#include <cmath>

namespace innergs {

/// Adam (Kingma & Ba 2015) over all parameters of a network, a multiple of 16.
class ParameterAdam {
public:
  explicit ParameterAdam(std::size_t count) : moment1_(count, 0.f), moment2_(count, 0.f) {}

  void apply(std::vector<float>& parameters, const std::vector<float>& gradient, double rate,
             const NetworkKernels& kernels) {
    constexpr double beta1 = 0.9, beta2 = 0.99;
    ++step_;
    kernels.adam({static_cast<float>(rate / (1 - std::pow(beta1, step_))), static_cast<float>(beta1),
                  static_cast<float>(beta2), static_cast<float>(1 / (1 - std::pow(beta2, step_)))},
                 static_cast<std::int64_t>(parameters.size()), gradient.data(), moment1_.data(),
                 moment2_.data(), parameters.data());
  }

private:
  std::vector<float> moment1_, moment2_;
  int step_ = 0;
};

} // namespace innergs
