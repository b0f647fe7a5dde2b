#include "Core/Prediction/Orthogonal.h"

#include <cmath>

namespace innergs {

void orthogonalise(std::vector<float>& values, std::int64_t rows, std::int64_t columns,
                   const MatrixKernels& kernels) {
  double squares = 0;
  for (const float v : values)
    squares += static_cast<double>(v) * v;
  const auto scale = static_cast<float>(1 / (std::sqrt(squares) + 1e-12));
  for (float& v : values)
    v *= scale;
  constexpr float a = 3.4445f, b = -4.7750f, c = 2.0315f;
  const auto size = static_cast<std::size_t>(columns * columns);
  std::vector<float> gram(size), next;
  for (int step = 0; step < 5; ++step) {
    gram.assign(size, 0.f);
    kernels.multiply({columns, rows, columns, values.data(), 1, columns, values.data(), gram.data()});
    // b·G + c·G², G = XᵀX
    std::vector<float> square(size, 0.f);
    kernels.multiply({columns, columns, columns, gram.data(), columns, 1, gram.data(), square.data()});
    for (std::size_t i = 0; i < size; ++i)
      square[i] = b * gram[i] + c * square[i];
    next.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      next[i] = a * values[i];
    kernels.multiply({rows, columns, columns, values.data(), columns, 1, square.data(), next.data()});
    values.swap(next);
  }
}

} // namespace innergs
