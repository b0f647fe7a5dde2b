#include "Core/Prediction/WinogradConvolution.h"

#include "Core/Base/Random.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr int kInputs = 16, kOutputs = 32;

std::vector<float> randomFloats(std::size_t count, Random& random) {
  std::vector<float> values(count);
  for (float& v : values)
    v = static_cast<float>(2 * random.uniform() - 1);
  return values;
}

struct Example {
  BorderedImage in, out;
  std::vector<float> image, weights, biases, gradient; // of the outputs

  Example(std::int64_t rows, std::int64_t columns)
      : in{rows, columns, kInputs}, out{rows, columns, kOutputs} {
    Random random(4);
    image.assign(in.size(), 0.f);
    gradient.assign(out.size(), 0.f);
    for (std::int64_t r = 0; r < rows; ++r)
      for (const auto& [layout, values] : {std::pair{&in, &image}, {&out, &gradient}}) {
        const auto row = randomFloats(static_cast<std::size_t>(columns * layout->channels), random);
        std::copy(row.begin(), row.end(), values->begin() + layout->row(r) + layout->channels);
      }
    weights = randomFloats(9 * kInputs * kOutputs, random);
    biases = randomFloats(kOutputs, random);
  }

  /// Calls visit(input, weight, output) with the indices of every product.
  template <typename Visit>
  void forProducts(const Visit& visit) const {
    for (std::int64_t r = 0; r < in.rows; ++r)
      for (std::int64_t c = 0; c < in.columns; ++c)
        for (int tap = 0; tap < 9; ++tap)
          for (int i = 0; i < kInputs; ++i)
            for (int o = 0; o < kOutputs; ++o)
              visit(in.row(r + tap / 3 - 1) + (c + tap % 3) * kInputs + i, (tap * kInputs + i) * kOutputs + o,
                    out.row(r) + (c + 1) * kOutputs + o);
  }
};

TEST(WinogradConvolution, IsThePlainSum) {
  // One tile, columns that do not fill a tile, and more rows than are computed at once.
  for (const auto& [rows, columns] : {std::pair{1, 4}, {7, 9}, {70, 21}}) {
    const Example e(rows, columns);
    std::vector<double> sum(e.out.size(), 0.0);
    e.forProducts([&](std::size_t i, std::size_t w, std::size_t o) {
      sum[o] += static_cast<double>(e.image[i]) * e.weights[w];
    });
    const auto transformed = WinogradConvolution::transformed(e.weights.data(), kInputs, kOutputs);
    std::vector<ColumnSpan> spans(static_cast<std::size_t>(rows));
    for (int r = 0; r < rows; r += 2)
      spans[r] = {r % columns / 2, static_cast<int>(columns) - r % 3};
    for (const NetworkKernels& set : networkKernelSets())
      for (const bool parts : {false, true}) {
        std::vector<float> out(e.out.size(), 5.f);
        WinogradConvolution convolution;
        convolution.convolve(e.in, e.image.data(), transformed, kOutputs,
                             parts ? std::span<const ColumnSpan>(spans) : std::span<const ColumnSpan>(),
                             e.biases.data(), 0.1f, set, out.data() + e.out.row(0));
        for (std::int64_t r = 0; r < rows; ++r)
          for (std::int64_t c = -1; c < e.out.width() - 1; ++c)
            for (int o = 0; o < kOutputs; ++o) {
              const std::size_t at = e.out.row(r) + (c + 1) * kOutputs + o;
              const double value = sum[at] + e.biases[o];
              const bool wanted = parts ? c >= spans[r].first && c < spans[r].last : c >= 0 && c < columns;
              ASSERT_NEAR(out[at], wanted ? std::max(value, 0.1 * value) : 0, 2e-4)
                  << set.name << " " << r << " " << c;
            }
        EXPECT_EQ(out[0], 5) << "border rows stay as they are";
        EXPECT_EQ(out.back(), 5);
      }
  }
}

TEST(WinogradConvolution, AddsTheGradientOfThePlainSum) {
  const Example e(33, 21);
  Random random(5);
  const auto start = randomFloats(e.weights.size(), random);
  std::vector<double> expected(start.begin(), start.end());
  e.forProducts([&](std::size_t i, std::size_t w, std::size_t o) {
    expected[w] += static_cast<double>(e.image[i]) * e.gradient[o];
  });
  for (const NetworkKernels& set : networkKernelSets()) {
    std::vector<float> gradient = start;
    WinogradConvolution convolution;
    convolution.addWeightGradient(e.in, e.image.data(), kOutputs, e.gradient.data(), set, gradient.data());
    for (std::size_t w = 0; w < gradient.size(); ++w)
      ASSERT_NEAR(gradient[w], expected[w], 2e-3) << set.name << " " << w;
  }
}

} // namespace
} // namespace innergs
