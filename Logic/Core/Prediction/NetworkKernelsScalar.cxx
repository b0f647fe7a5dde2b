#include "Core/Prediction/NetworkKernels.h"

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

// Bᵀ and A of F(6, 3), with the points 0, ±1, ±2, ±1/2 and infinity
constexpr Points<8> kInput = {{{1, 0, -5.25f, 0, 5.25f, 0, -1, 0},
                               {0, 1, 1, -4.25f, -4.25f, 1, 1, 0},
                               {0, -1, 1, 4.25f, -4.25f, -1, 1, 0},
                               {0, 0.5f, 0.25f, -2.5f, -1.25f, 2, 1, 0},
                               {0, -0.5f, 0.25f, 2.5f, -1.25f, -2, 1, 0},
                               {0, 2, 4, -2.5f, -5, 0.5f, 1, 0},
                               {0, -2, 4, 2.5f, -5, -0.5f, 1, 0},
                               {0, -1, 0, 5.25f, 0, -5.25f, 0, 1}}};
constexpr Points<6> kOutput = {{{1, 0, 0, 0, 0, 0},
                                {1, 1, 1, 1, 1, 1},
                                {1, -1, 1, -1, 1, -1},
                                {1, 2, 4, 8, 16, 32},
                                {1, -2, 4, -8, 16, -32},
                                {1, 1.f / 2, 1.f / 4, 1.f / 8, 1.f / 16, 1.f / 32},
                                {1, -1.f / 2, 1.f / 4, -1.f / 8, 1.f / 16, -1.f / 32},
                                {0, 0, 0, 0, 0, 1}}};

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

NetworkKernels scalarNetworkKernels() {
  return {"scalar",     multiply, inputToPoints, outputOfPoints, gradientToPoints, activate,
          activateBack, addSums,  adam};
}

} // namespace innergs
