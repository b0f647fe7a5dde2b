#include "Core/Prediction/MatrixKernels.h"

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

TEST(MatrixKernels, AllInstructionSetsMultiplyAsTheScalarReference) {
  struct Case {
    std::int64_t rows, depth, columns, rowStep, step;
  };
  // Ordinary, transposed, and overlapping rows as in a convolution; also rows that do not fill a block.
  const Case cases[] = {{1, 1, 16, 1, 1}, {13, 63, 32, 64, 1}, {64, 29, 48, 1, 64}, {27, 96, 16, 32, 1}};
  for (const Case& c : cases) {
    const auto a =
        randomFloats(static_cast<std::size_t>((c.rows - 1) * c.rowStep + (c.depth - 1) * c.step + 1), 1);
    const auto b = randomFloats(static_cast<std::size_t>(c.depth * c.columns), 2);
    const auto start = randomFloats(static_cast<std::size_t>(c.rows * c.columns), 3);
    std::vector<float> expected = start;
    scalarMatrixKernels().multiplyAdd(
        {c.rows, c.depth, c.columns, a.data(), c.rowStep, c.step, b.data(), expected.data()});
    EXPECT_NE(expected, start);
    for (const MatrixKernels& set : matrixKernelSets()) {
      std::vector<float> out = start;
      set.multiplyAdd({c.rows, c.depth, c.columns, a.data(), c.rowStep, c.step, b.data(), out.data()});
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], expected[i], 2e-5) << set.name << " " << i;
    }
  }
}

TEST(MatrixKernels, AllInstructionSetsStepAsTheScalarReference) {
  constexpr std::size_t count = 48;
  const auto gradient = randomFloats(count, 4);
  const AdamScalars step{0.01f, 0.9f, 0.98f, 1.5f};
  const auto after = [&](const MatrixKernels& set) {
    auto first = randomFloats(count, 5), second = randomFloats(count, 6), x = randomFloats(count, 7);
    for (float& v : second)
      v = std::abs(v);
    set.adam(step, count, gradient.data(), first.data(), second.data(), x.data());
    for (const auto* more : {&first, &second})
      x.insert(x.end(), more->begin(), more->end());
    return x;
  };
  const auto expected = after(scalarMatrixKernels());
  for (const MatrixKernels& set : matrixKernelSets()) {
    const auto out = after(set);
    for (std::size_t i = 0; i < out.size(); ++i)
      ASSERT_NEAR(out[i], expected[i], 1e-6) << set.name << " " << i;
  }
}

TEST(MatrixKernels, AnUnknownInstructionSetIsRefused) {
  EXPECT_EQ(matrixKernels("").name, matrixKernelSets().front().name);
  EXPECT_EQ(matrixKernels("scalar").name, "scalar");
  EXPECT_THROW(matrixKernels("abacus"), Error);
}

} // namespace
} // namespace innergs
