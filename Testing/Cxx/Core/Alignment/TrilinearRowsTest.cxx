#include "Core/Alignment/TrilinearRows.h"

#include "Core/Base/InstructionSets.h"
#include "Core/Base/Random.h"
#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

bool isInside(const PointRow& row, int i) {
  for (int a = 0; a < 3; ++a) {
    const float x = row.start[a] + static_cast<float>(i) * row.step[a];
    if (!(x >= 0.001F && x <= static_cast<float>(row.size[a] - 1) - 0.001F)) return false;
  }
  return true;
}

PointRow randomRow(const std::array<std::int64_t, 3>& size, Random& random) {
  PointRow row{size, {}, {}};
  for (int a = 0; a < 3; ++a) {
    row.start[a] = static_cast<float>(random.uniform() * (static_cast<double>(size[a]) + 6) - 3);
    row.step[a] = static_cast<float>((random.uniform() - 0.5) * 1.5);
  }
  return row;
}

/// Of each instruction set but the reference.
class TrilinearRowsOf : public ::testing::TestWithParam<std::string> {
protected:
  const TrilinearRows& reference_ = kernelsOf(trilinearRows(), "scalar");
  const TrilinearRows& rows_ = kernelsOf(trilinearRows(), GetParam());
};

std::vector<std::string> fastSets() {
  std::vector<std::string> names;
  for (const TrilinearRows& set : trilinearRows())
    if (set.name != "scalar") names.push_back(set.name);
  return names;
}

} // namespace

TEST(TrilinearRows, ReadLinearVolumesExactly) {
  Volume volume = randomVolume(grid(9, 8, 7), 0, 0, 1);
  const auto plane = [](double x, double y, double z) { return 3 + x - 2 * y + 0.5 * z; };
  for (std::size_t v = 0; v < volume.voxels.size(); ++v)
    volume.voxels[v] = static_cast<float>(plane(v % 9, v / 9 % 8, v / 72));
  const PointRow row{volume.geometry.size, {0, 0.25F, 6}, {0.5F, 0.25F, -0.125F}};
  for (const TrilinearRows& set : trilinearRows()) {
    std::vector<float> values(16, 0.F);
    set.read(volume.voxels.data(), row, 2, 0, 16, values.data());
    for (int i = 0; i < 16; ++i)
      EXPECT_NEAR(values[i], 2 * plane(0.5 * i, 0.25 + 0.25 * i, 6 - 0.125 * i), 1e-4) << set.name;
  }
}

TEST_P(TrilinearRowsOf, ReadWhatTheReferenceReads) {
  const Volume volume = randomVolume(grid(23, 17, 11), -1, 1, 3);
  Random random(5);
  int inside = 0, points = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const PointRow row = randomRow(volume.geometry.size, random);
    const int begin = trial % 5, end = begin + trial;
    std::vector<float> expected(static_cast<std::size_t>(end) + 3, 0.25F);
    for (int i = 0; i < end; ++i)
      if (!isInside(row, i)) expected[i] = kNaN;
    std::vector<float> got = expected;
    reference_.read(volume.voxels.data(), row, 0.7F, begin, end, expected.data());
    rows_.read(volume.voxels.data(), row, 0.7F, begin, end, got.data());
    for (std::size_t i = 0; i < got.size(); ++i) {
      ASSERT_EQ(std::isnan(got[i]), std::isnan(expected[i]));
      if (std::isnan(got[i])) continue;
      EXPECT_NEAR(got[i], expected[i], 1e-5) << "point " << i;
    }
    for (int i = begin; i < end; ++i)
      inside += isInside(row, i);
    points += end - begin;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_LT(inside, points);
}

TEST_P(TrilinearRowsOf, AddWhatTheReferenceAdds) {
  const Volume volume = randomVolume(grid(23, 17, 11), -1, 1, 3);
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const PointRow row = randomRow(volume.geometry.size, random);
    const int begin = trial % 5, end = begin + trial;
    std::vector<float> values(static_cast<std::size_t>(end));
    for (int i = 0; i < end; ++i)
      values[i] = isInside(row, i) ? static_cast<float>(random.uniform() - 0.5) : 0;
    std::vector<float> expected = volume.voxels, got = expected;
    const std::int64_t first = trial % 4, last = first + trial % 8;
    reference_.add(values.data(), row, 0.7F, begin, end, first, last, expected.data());
    rows_.add(values.data(), row, 0.7F, begin, end, first, last, got.data());
    for (std::size_t v = 0; v < got.size(); ++v) {
      const auto k = static_cast<std::int64_t>(v / (23 * 17));
      const bool owned = k >= first && k < last;
      EXPECT_NEAR(got[v], owned ? expected[v] : volume.voxels[v], owned ? 1e-5 : 0) << "voxel " << v;
    }
  }
}

/// ⟨A x, y⟩ = ⟨x, Aᵀ y⟩.
TEST_P(TrilinearRowsOf, AddTheTransposeOfWhatTheyRead) {
  const Volume x = randomVolume(grid(23, 17, 11), -1, 1, 7);
  Random random(8);
  for (int trial = 0; trial < 50; ++trial) {
    const PointRow row = randomRow(x.geometry.size, random);
    std::vector<float> seen(100), y(100);
    double left = 0, right = 0;
    for (int i = 0; i < 100; ++i) {
      seen[i] = isInside(row, i) ? 0 : kNaN;
      y[i] = isInside(row, i) ? static_cast<float>(random.uniform() - 0.5) : 0;
    }
    rows_.read(x.voxels.data(), row, 0.3F, 0, 100, seen.data());
    std::vector<float> volume(x.voxels.size(), 0.F);
    rows_.add(y.data(), row, 0.3F, 0, 100, 0, 11, volume.data());
    for (int i = 0; i < 100; ++i)
      if (!std::isnan(seen[i])) left += static_cast<double>(seen[i]) * y[i];
    for (std::size_t v = 0; v < volume.size(); ++v)
      right += static_cast<double>(volume[v]) * x.voxels[v];
    EXPECT_NEAR(left, right, 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, TrilinearRowsOf, ::testing::ValuesIn(fastSets()),
                         [](const auto& set) { return set.param; });
