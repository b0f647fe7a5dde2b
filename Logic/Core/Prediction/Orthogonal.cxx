#include "Core/Prediction/Orthogonal.h"

#include <cmath>

namespace innergs {

void orthogonalise(std::vector<float>& values, std::int64_t rows, std::int64_t columns,
                   const NetworkKernels& kernels) {
  double squares = 0;
  for (const float v : values)
    squares += static_cast<double>(v) * v;
  const auto scale = static_cast<float>(1 / (std::sqrt(squares) + 1e-12));
  for (float& v : values)
    v *= scale;
  constexpr float a = 3.4445f, b = -4.7750f, c = 2.0315f;
  // X becomes X·P in every step, P = a + b·G + c·G², G = XᵀX. All P commute, so G becomes G·P² and only their
  // product meets the long columns of X.
  const auto size = static_cast<std::size_t>(columns * columns);
  const auto product = [&](const std::vector<float>& x, const std::vector<float>& y) {
    std::vector<float> xy(size);
    kernels.multiply({.rows = columns,
                      .depth = columns,
                      .columns = columns,
                      .a = x.data(),
                      .rowStep = columns,
                      .b = y.data(),
                      .c = xy.data(),
                      .add = false});
    return xy;
  };
  std::vector<float> gram(size), all;
  kernels.multiply({.rows = columns,
                    .depth = rows,
                    .columns = columns,
                    .a = values.data(),
                    .rowStep = 1,
                    .step = columns,
                    .b = values.data(),
                    .c = gram.data(),
                    .add = false});
  constexpr int steps = 5;
  for (int step = 0; step < steps; ++step) {
    std::vector<float> p = product(gram, gram);
    for (std::size_t i = 0; i < size; ++i)
      p[i] = b * gram[i] + c * p[i];
    for (std::int64_t i = 0; i < columns; ++i)
      p[i * columns + i] += a;
    all = step == 0 ? p : product(all, p);
    if (step + 1 < steps) gram = product(product(gram, p), p);
  }
  std::vector<float> result(values.size());
  kernels.multiply({.rows = rows,
                    .depth = columns,
                    .columns = columns,
                    .a = values.data(),
                    .rowStep = columns,
                    .b = all.data(),
                    .c = result.data(),
                    .add = false});
  values.swap(result);
}

} // namespace innergs
