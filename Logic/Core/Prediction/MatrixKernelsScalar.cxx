#include "Core/Prediction/MatrixKernels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs {
namespace {

void multiply(const MatrixProduct& p) {
  if (!p.add) std::fill_n(p.c, p.rows * p.columns, 0.f);
  for (std::int64_t m = 0; m < p.rows; ++m)
    for (std::int64_t s = 0; s < p.segments; ++s)
      for (std::int64_t k = 0; k < p.depth; ++k) {
        const float a = p.a[m * p.rowStep + s * p.segmentStep + k * p.step];
        for (std::int64_t n = 0; n < p.columns; ++n)
          p.c[m * p.columns + n] += a * p.b[(s * p.depth + k) * p.columns + n];
      }
}

/// A matrix with one row per point and one column per column of the image.
template <std::size_t columns>
using Points = std::array<std::array<float, columns>, ImageTiles::points>;

// Bᵀ and A of F(4, 3)
constexpr Points<6> kInput = {{{4, 0, -5, 0, 1, 0},
                               {0, -4, -4, 1, 1, 0},
                               {0, 4, -4, -1, 1, 0},
                               {0, -2, -1, 2, 1, 0},
                               {0, 2, -1, -2, 1, 0},
                               {0, 4, 0, -5, 0, 1}}};
constexpr Points<4> kOutput = {
    {{1, 0, 0, 0}, {1, 1, 1, 1}, {1, -1, 1, -1}, {1, 2, 4, 8}, {1, -2, 4, -8}, {0, 0, 0, 1}}};

template <std::size_t columns>
void toPoints(const Points<columns>& transform, const ImageTiles& tiles, const float* image, float* points) {
  for (std::int64_t t = 0; t < tiles.count; ++t)
    for (int p = 0; p < ImageTiles::points; ++p)
      for (int c = 0; c < tiles.channels; ++c) {
        float sum = 0;
        for (std::size_t i = 0; i < columns; ++i)
          sum += transform[p][i] *
                 image[(t * ImageTiles::width + static_cast<std::int64_t>(i)) * tiles.channels + c];
        points[p * tiles.pointStep + t * tiles.channels + c] = sum;
      }
}

void inputToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  toPoints(kInput, tiles, columns, points);
}

void gradientToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  toPoints(kOutput, tiles, columns, points);
}

void outputOfPoints(const ImageTiles& tiles, const float* points, const float* biases, float leak,
                    float* columns) {
  for (std::int64_t t = 0; t < tiles.count; ++t)
    for (int i = 0; i < ImageTiles::width; ++i)
      for (int c = 0; c < tiles.channels; ++c) {
        float sum = biases[c];
        for (int p = 0; p < ImageTiles::points; ++p)
          sum += kOutput[p][i] * points[p * tiles.pointStep + t * tiles.channels + c];
        columns[(t * ImageTiles::width + i) * tiles.channels + c] = std::max(sum, leak * sum);
      }
}

void activate(std::int64_t samples, int channels, const float* biases, float leak, float* values) {
  for (std::int64_t s = 0; s < samples; ++s)
    for (int c = 0; c < channels; ++c) {
      float& v = values[s * channels + c];
      v += biases[c];
      v = std::max(v, leak * v);
    }
}

void activateBack(std::int64_t samples, int channels, const float* activated, float leak, float* gradient) {
  for (std::int64_t i = 0; i < samples * channels; ++i)
    gradient[i] *= activated[i] > 0 ? 1.f : leak;
}

void addSums(std::int64_t samples, int channels, const float* values, float* sums) {
  for (std::int64_t s = 0; s < samples; ++s)
    for (int c = 0; c < channels; ++c)
      sums[c] += values[s * channels + c];
}

void normalise(int count, float floor, float* values, float& mean, float& deviation) {
  float sum = 0;
  for (int i = 0; i < count; ++i)
    sum += values[i];
  mean = sum / static_cast<float>(count);
  float squares = 0;
  for (int i = 0; i < count; ++i) {
    values[i] -= mean;
    squares += values[i] * values[i];
  }
  values[count] = 0;
  deviation = floor > 0 ? std::sqrt(squares / static_cast<float>(count) + floor * floor) : 1;
  for (int i = 0; i < count; ++i)
    values[i] *= 1 / deviation;
}

void adam(const AdamScalars& s, std::int64_t count, const float* gradient, float* moment1, float* moment2,
          float* parameters) {
  constexpr float tiny = 1e-8f;
  for (std::int64_t i = 0; i < count; ++i) {
    moment1[i] = s.beta1 * moment1[i] + (1 - s.beta1) * gradient[i];
    moment2[i] = s.beta2 * moment2[i] + (1 - s.beta2) * gradient[i] * gradient[i];
    parameters[i] -= s.rate * moment1[i] / (std::sqrt(moment2[i] * s.scale2) + tiny);
  }
}

} // namespace

MatrixKernels scalarMatrixKernels() {
  return {"scalar", multiply,     inputToPoints, outputOfPoints, gradientToPoints,
          activate, activateBack, addSums,       normalise,      adam};
}

} // namespace innergs
