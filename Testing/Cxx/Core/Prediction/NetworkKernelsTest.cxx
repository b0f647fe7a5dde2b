#include "Core/Prediction/NetworkKernels.h"

#include "Core/Base/Error.h"
#include "Core/Base/Random.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

std::vector<float> randomFloats(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values)
    v = static_cast<float>(2 * random.uniform() - 1);
  return values;
}

TEST(NetworkKernels, AllInstructionSetsMultiplyAsTheScalarReference) {
  // Ordinary, transposed, and with overlapping rows; rows that do not fill a block; segments that lie apart.
  const MatrixProduct cases[] = {{.rows = 1, .depth = 1, .columns = 16, .rowStep = 1},
                                 {.rows = 13, .depth = 63, .columns = 32, .rowStep = 64},
                                 {.rows = 31, .depth = 9, .columns = 8, .rowStep = 9},
                                 {.rows = 5, .depth = 12, .columns = 24, .rowStep = 12, .add = false},
                                 {.rows = 64, .depth = 29, .columns = 48, .rowStep = 1, .step = 64},
                                 {.rows = 27, .depth = 96, .columns = 16, .rowStep = 32, .add = false},
                                 {.rows = 32,
                                  .depth = 16,
                                  .columns = 32,
                                  .rowStep = 16,
                                  .segments = 3,
                                  .segmentStep = 40,
                                  .add = false}};
  for (MatrixProduct c : cases) {
    const auto a = randomFloats(static_cast<std::size_t>((c.rows - 1) * c.rowStep + (c.depth - 1) * c.step +
                                                         (c.segments - 1) * c.segmentStep + 1),
                                1);
    const auto b = randomFloats(static_cast<std::size_t>(c.segments * c.depth * c.columns), 2);
    const auto start = randomFloats(static_cast<std::size_t>(c.rows * c.columns), 3);
    std::vector<double> expected(start.begin(), start.end());
    for (std::int64_t m = 0; m < c.rows; ++m)
      for (std::int64_t n = 0; n < c.columns; ++n) {
        double& sum = expected[m * c.columns + n];
        if (!c.add) sum = 0;
        for (std::int64_t s = 0; s < c.segments; ++s)
          for (std::int64_t k = 0; k < c.depth; ++k)
            sum += static_cast<double>(a[m * c.rowStep + s * c.segmentStep + k * c.step]) *
                   b[(s * c.depth + k) * c.columns + n];
      }
    c.a = a.data();
    c.b = b.data();
    for (const NetworkKernels& set : networkKernelSets()) {
      std::vector<float> out = start;
      c.c = out.data();
      set.multiply(c);
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], expected[i], 2e-5) << set.name << " " << i;
    }
  }
}

TEST(NetworkKernels, AllInstructionSetsTransformTilesAsTheScalarReference) {
  for (const int channels : {8, 32}) {
    const ImageTiles tiles{3, channels, 5 * channels};
    const auto columns = randomFloats((3 * ImageTiles::width + 2) * channels, 8),
               points = randomFloats(ImageTiles::points * 5 * channels, 9),
               biases = randomFloats(channels, 10);
    const auto all = [&](const NetworkKernels& set) {
      std::vector<float> input(points.size(), 0.f), gradient = input, output(columns.size(), 0.f);
      set.inputToPoints(tiles, columns.data(), input.data());
      set.gradientToPoints(tiles, columns.data(), gradient.data());
      set.outputOfPoints(tiles, points.data(), biases.data(), 0.1f, output.data());
      for (const auto* more : {&gradient, &output})
        input.insert(input.end(), more->begin(), more->end());
      return input;
    };
    const auto expected = all(scalarNetworkKernels());
    for (const NetworkKernels& set : networkKernelSets()) {
      const auto out = all(set);
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], expected[i], 1e-5) << set.name << " " << i;
    }
  }
}

TEST(NetworkKernels, AllInstructionSetsActivateAsTheScalarReference) {
  constexpr int samples = 5;
  for (const int channels : {8, 32}) {
    const auto values = randomFloats(samples * channels, 11), biases = randomFloats(channels, 12);
    const auto all = [&](const NetworkKernels& set) {
      std::vector<float> out = values, gradient = values, sums = biases;
      set.activate(samples, channels, biases.data(), 0.1f, out.data());
      set.activateBack(samples, channels, out.data(), 0.1f, gradient.data());
      set.addSums(samples, channels, values.data(), sums.data());
      for (const auto* more : {&gradient, &sums})
        out.insert(out.end(), more->begin(), more->end());
      return out;
    };
    const auto expected = all(scalarNetworkKernels());
    EXPECT_FLOAT_EQ(expected[0], std::max(values[0] + biases[0], 0.1f * (values[0] + biases[0])));
    for (const NetworkKernels& set : networkKernelSets()) {
      const auto out = all(set);
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], expected[i], 1e-6) << set.name << " " << i;
    }
  }
}

TEST(NetworkKernels, AllInstructionSetsStepAsTheScalarReference) {
  for (const std::size_t count : {8, 48}) {
    const auto gradient = randomFloats(count, 4);
    const AdamScalars step{0.01f, 0.9f, 0.98f, 1.5f};
    const auto after = [&](const NetworkKernels& set) {
      auto first = randomFloats(count, 5), second = randomFloats(count, 6), x = randomFloats(count, 7);
      for (float& v : second)
        v = std::abs(v);
      set.adam(step, count, gradient.data(), first.data(), second.data(), x.data());
      for (const auto* more : {&first, &second})
        x.insert(x.end(), more->begin(), more->end());
      return x;
    };
    const auto expected = after(scalarNetworkKernels());
    for (const NetworkKernels& set : networkKernelSets()) {
      const auto out = after(set);
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], expected[i], 1e-6) << set.name << " " << i;
    }
  }
}

TEST(NetworkKernels, AnUnknownInstructionSetIsRefused) {
  EXPECT_EQ(networkKernels("").name, networkKernelSets().front().name);
  EXPECT_EQ(networkKernels("scalar").name, "scalar");
  EXPECT_THROW(networkKernels("abacus"), Error);
}

} // namespace
} // namespace innergs
