#include "Core/Render/Kernels.h"
#include "RandomFields.h"
#include "ThrownError.h"

#include <gtest/gtest.h>
#include <numeric>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// Gaussians from a twentieth of a voxel to larger than the grid; some partly, some entirely outside.
std::vector<Projected> cloud(const SampleGrid& grid, std::uint64_t seed, ThreadPool& pool,
                             Selection selection = Selection::Exact) {
  GaussianField field;
  field.linearIntensity = true;
  field.cutoff = 3;
  Numbers random(seed);
  const double nx = grid.nx, ny = grid.ny, nz = grid.planes();
  for (const double sigma : {0.05, 0.3, 0.8, 1.5, 4.0, 12.0, 60.0}) {
    Cloud c;
    c.low = {-0.4 * nx - 3, -0.4 * ny - 3, -0.4 * nz - 3};
    c.high = {1.4 * nx + 3, 1.4 * ny + 3, 1.4 * nz + 3};
    c.minSigma = 0.8 * sigma;
    c.maxSigma = 1.25 * sigma;
    c.anisotropy = 4;
    for (int i = 0; i < 30; ++i)
      field.gaussians.push_back(randomGaussian(random, c));
  }
  std::vector<Projected> projected;
  project(field, {}, grid, {}, pool, projected, selection);
  return projected;
}

struct Buffers {
  std::vector<float> a, b;
  Buffers(const SampleGrid& grid, float value) : a(grid.bufferSize(), value), b(grid.bufferSize(), value) {}
};

} // namespace

TEST(Kernels, ScalarIsTheLastOfSeveralSets) {
  const auto& sets = kernelSets();
  ASSERT_GE(sets.size(), 2u);
  EXPECT_EQ(sets.back().name, "scalar");
  EXPECT_EQ(&kernelSet(""), &sets.front());
  for (const KernelSet& set : sets)
    EXPECT_EQ(&kernelSet(set.name), &set);
  const Error error = test::errorOf([] { kernelSet("MMX"); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_TRUE(test::contains(error, "scalar")) << "the sentence names the choices";
}

class KernelsOfWidth : public ::testing::TestWithParam<std::tuple<int, Selection>> {
protected:
  void SetUp() override {
    grid.nx = std::get<0>(GetParam());
    grid.ny = 13;
    for (int k = 0; k < 7; ++k)
      grid.z.push_back(0.9 * k + 0.1);
    grid.indexToModel.linear[0] = {0.98, 0.10, -0.17};
    grid.indexToModel.linear[1] = {-0.12, 0.99, -0.06};
    grid.indexToModel.linear[2] = {0.16, 0.08, 0.98};
    projected = cloud(grid, 100 + grid.nx, pool, selection);
    ids.resize(projected.size());
    std::iota(ids.begin(), ids.end(), 0u);
  }

  GridView view() const { return {grid.nx, grid.ny, grid.planes(), grid.stride(), grid.z.data()}; }

  const Selection selection = std::get<1>(GetParam());
  ThreadPool pool{1};
  SampleGrid grid;
  std::vector<Projected> projected;
  std::vector<std::uint32_t> ids;
};

TEST_P(KernelsOfWidth, AccumulateAsTheScalarSet) {
  const TileRange all{0, grid.ny, 0, grid.planes()};
  Buffers expected(grid, 0);
  kernelSet("scalar", selection)
      .accumulate(projected.data(), ids.data(), ids.size(), view(), all, expected.a.data(),
                  expected.b.data());
  double covered = 0;
  for (const KernelSet& set : kernelSets(selection)) {
    SCOPED_TRACE(set.name);
    Buffers got(grid, 0);
    set.accumulate(projected.data(), ids.data(), ids.size(), view(), all, got.a.data(), got.b.data());
    for (int row = 0; row < grid.ny * grid.planes(); ++row)
      for (int x = 0; x < grid.nx; ++x) {
        const std::size_t v = static_cast<std::size_t>(row) * grid.stride() + x;
        covered += expected.a[v] > 0;
        ASSERT_NEAR(got.a[v], expected.a[v], 1e-5 * std::abs(expected.a[v]) + 1e-6)
            << "column " << x << " row " << row;
        // Numerators sum values of either sign: relative to the sum of magnitudes.
        ASSERT_NEAR(got.b[v], expected.b[v], 1e-5 * (std::abs(expected.b[v]) + 3 * expected.a[v]) + 1e-6)
            << "column " << x << " row " << row;
      }
  }
  EXPECT_GT(covered, 0);
}

TEST_P(KernelsOfWidth, AccumulateOnlyInTheTile) {
  const TileRange tile{3, 8, 2, 5};
  constexpr float before = 7;
  Buffers whole(grid, before);
  const TileRange all{0, grid.ny, 0, grid.planes()};
  for (const KernelSet& set : kernelSets(selection)) {
    SCOPED_TRACE(set.name);
    std::fill(whole.a.begin(), whole.a.end(), before);
    std::fill(whole.b.begin(), whole.b.end(), before);
    set.accumulate(projected.data(), ids.data(), ids.size(), view(), all, whole.a.data(), whole.b.data());
    Buffers got(grid, before);
    set.accumulate(projected.data(), ids.data(), ids.size(), view(), tile, got.a.data(), got.b.data());
    for (int k = 0; k < grid.planes(); ++k)
      for (int y = 0; y < grid.ny; ++y) {
        const bool inside = y >= tile.y0 && y < tile.y1 && k >= tile.k0 && k < tile.k1;
        for (int x = 0; x < grid.nx; ++x) {
          const std::size_t v = (static_cast<std::size_t>(k) * grid.ny + y) * grid.stride() + x;
          if (inside) {
            ASSERT_EQ(got.a[v], whole.a[v]) << "a grid's division must not show";
            ASSERT_EQ(got.b[v], whole.b[v]);
          } else {
            ASSERT_EQ(got.a[v], before);
            ASSERT_EQ(got.b[v], before);
          }
        }
      }
  }
}

TEST_P(KernelsOfWidth, AddToWhatIsThereInTheOrderGiven) {
  const TileRange all{0, grid.ny, 0, grid.planes()};
  for (const KernelSet& set : kernelSets(selection)) {
    SCOPED_TRACE(set.name);
    Buffers once(grid, 0), twice(grid, 0);
    const std::size_t half = ids.size() / 2;
    set.accumulate(projected.data(), ids.data(), ids.size(), view(), all, once.a.data(), once.b.data());
    set.accumulate(projected.data(), ids.data(), half, view(), all, twice.a.data(), twice.b.data());
    set.accumulate(projected.data(), ids.data() + half, ids.size() - half, view(), all, twice.a.data(),
                   twice.b.data());
    EXPECT_EQ(once.a, twice.a);
    EXPECT_EQ(once.b, twice.b);
  }
}

TEST_P(KernelsOfWidth, GatherAsTheScalarSet) {
  Numbers random(3);
  Buffers f(grid, 0); // zero in the padding
  for (int row = 0; row < grid.ny * grid.planes(); ++row)
    for (int x = 0; x < grid.nx; ++x) {
      const std::size_t v = static_cast<std::size_t>(row) * grid.stride() + x;
      f.a[v] = static_cast<float>(random(-1, 1));
      f.b[v] = static_cast<float>(random(-1, 1));
    }
  std::vector<float> ones(grid.bufferSize(), 0.f);
  for (std::size_t v = 0; v < ones.size(); ++v)
    ones[v] = std::abs(f.a[v]) + std::abs(f.b[v]);
  constexpr int kCount = sizeof(math::Moments<float>) / sizeof(float);
  static_assert(kCount == 14);
  int reached = 0;
  for (std::size_t i = 0; i < projected.size(); ++i) {
    math::Moments<float> expected;
    kernelSet("scalar", selection).gather(projected[i], view(), f.a.data(), f.b.data(), expected);
    const Projected& g = projected[i];
    const double reach = 1 + std::max({g.half[0], g.half[1], g.half[2]});
    // The magnitude of the sum: moments of absolute values, bounded by Σ|f|·q times powers of the reach on
    // the grid.
    math::Moments<float> absolute;
    Projected plain = g;
    plain.value = 1;
    std::fill_n(plain.slope, 3, 0.f);
    kernelSet("scalar", selection).gather(plain, view(), ones.data(), ones.data(), absolute);
    reached += absolute.n0 > 0;
    const double length = std::min<double>(reach, 60), value = 1 + 0.3 * length;
    for (const KernelSet& set : kernelSets(selection)) {
      SCOPED_TRACE(set.name + ", Gaussian " + std::to_string(i));
      math::Moments<float> got;
      set.gather(g, view(), f.a.data(), f.b.data(), got);
      const float* e = reinterpret_cast<const float*>(&expected);
      const float* m = reinterpret_cast<const float*>(&got);
      for (int c = 0; c < kCount; ++c) {
        const double power = c == 0 || c == 10 ? 1 : c < 4 || c > 10 ? length : length * length;
        ASSERT_NEAR(m[c], e[c], 1e-4 * std::abs(e[c]) + 2e-6 * value * power * (absolute.m0 + 1e-3))
            << "moment " << c;
      }
    }
  }
  EXPECT_GT(reached, 40);
}

INSTANTIATE_TEST_SUITE_P(Rows, KernelsOfWidth,
                         ::testing::Combine(::testing::Values(1, 2, 15, 16, 17, 33, 70),
                                            ::testing::Values(Selection::Exact, Selection::Method1,
                                                              Selection::Method2)),
                         [](const auto& info) {
                           return std::to_string(std::get<0>(info.param)) +
                                  selectionName(std::get<1>(info.param));
                         });

TEST(Kernels, KeepTheirPrecisionDownTheRows) {
  // Vector sets take exponentials in some rows only.
  ThreadPool pool(1);
  SampleGrid grid;
  grid.nx = grid.ny = 64;
  for (int k = 0; k < 5; ++k)
    grid.z.push_back(k);
  const GridView view{grid.nx, grid.ny, grid.planes(), grid.stride(), grid.z.data()};
  const TileRange all{0, grid.ny, 0, grid.planes()};
  for (const double sigma : {0.1, 1.0, 8.0}) {
    GaussianField field;
    Numbers random(11);
    Cloud c;
    c.low = {20, 20, 0};
    c.high = {44, 44, 4};
    c.minSigma = c.maxSigma = sigma;
    c.anisotropy = 6;
    for (int i = 0; i < 100; ++i)
      field.gaussians.push_back(randomGaussian(random, c));
    std::vector<Projected> projected;
    project(field, {}, grid, {}, pool, projected);
    for (std::uint32_t i = 0; i < projected.size(); ++i) {
      Buffers expected(grid, 0);
      kernelSet("scalar").accumulate(projected.data(), &i, 1, view, all, expected.a.data(),
                                     expected.b.data());
      for (const KernelSet& set : kernelSets()) {
        SCOPED_TRACE(set.name + ", standard deviation " + std::to_string(sigma));
        Buffers got(grid, 0);
        set.accumulate(projected.data(), &i, 1, view, all, got.a.data(), got.b.data());
        for (std::size_t v = 0; v < got.a.size(); ++v)
          ASSERT_NEAR(got.a[v], expected.a[v], 1e-5 * (expected.a[v] + projected[i].cut));
      }
    }
  }
}

TEST(Kernels, KeepTheirPrecisionFarFromTheOrigin) {
  // Offsets of a Gaussian to voxels must not lose bits because of a large patient coordinate.
  SampleGrid near, far;
  near.nx = far.nx = 20;
  near.ny = far.ny = 9;
  near.z = far.z = {0, 1, 2, 3, 4};
  GaussianField field;
  Numbers random(5);
  Cloud c;
  c.low = {0, 0, 0};
  c.high = {20, 9, 5};
  for (int i = 0; i < 20; ++i) {
    Gaussian g = randomGaussian(random, c);
    for (float& x : g.mean)
      x = std::round(x * 64) / 64; // still representable after the shift
    field.gaussians.push_back(g);
  }
  GaussianField moved = field;
  for (Gaussian& g : moved.gaussians)
    for (float& x : g.mean)
      x += 4096;
  far.indexToModel.offset = {4096, 4096, 4096};
  ThreadPool pool(1);
  std::vector<Projected> a, b;
  project(field, {}, near, {}, pool, a);
  project(moved, {}, far, {}, pool, b);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(a[i].cell[k], b[i].cell[k]);
      EXPECT_EQ(a[i].fraction[k], b[i].fraction[k]);
    }
}
