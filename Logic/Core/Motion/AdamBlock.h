#pragma once
#include "Core/Base/Parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace innergs {

/// Adam (Kingma & Ba 2015) over a block of parameters with its own step count, so that blocks of coefficients
/// that a time does not reach stay as they are.
class AdamBlock {
public:
  explicit AdamBlock(std::size_t count) : moment1(count, 0.f), moment2(count, 0.f) {}

  /// gradient(i), rate(i): of x[i].
  template <class Gradient, class Rate>
  void apply(float* x, const Gradient& gradient, const Rate& rate, ThreadPool& pool) {
    constexpr float b1 = 0.9f, b2 = 0.99f, tiny = 1e-12f;
    ++steps;
    const auto c1 = static_cast<float>(1 / (1 - std::pow(0.9, steps)));
    const auto c2 = static_cast<float>(1 / (1 - std::pow(0.99, steps)));
    constexpr std::int64_t block = 8192;
    const auto count = static_cast<std::int64_t>(moment1.size());
    pool.runToEnd((count + block - 1) / block, [&](std::int64_t n) {
      for (std::int64_t i = n * block; i < std::min(count, (n + 1) * block); ++i) {
        const float g = gradient(i);
        moment1[i] = b1 * moment1[i] + (1 - b1) * g;
        moment2[i] = b2 * moment2[i] + (1 - b2) * g * g;
        x[i] -= rate(i) * c1 * moment1[i] / (std::sqrt(moment2[i] * c2) + tiny);
      }
    });
  }

  std::vector<float> moment1, moment2;
  int steps = 0; // done
};

} // namespace innergs
