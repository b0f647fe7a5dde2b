#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "RandomFields.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"

#include <cstring>
#include <gtest/gtest.h>
#include <numeric>

using namespace innergs;
using namespace innergs::testing;

namespace {

GridGeometry oblique() {
  return grid(21, 18, 13, {1.0, 1.2, 1.5}, {30, -20, 55}, obliqueDirection(0.8));
}

/// Opacities from 0.05 to 0.95, some Gaussians beyond the border.
GaussianField alphaField(int gaussians, std::uint64_t seed) {
  Cloud cloud;
  cloud.low = {-12, -12, -12};
  cloud.high = {12, 12, 12};
  cloud.minSigma = 0.7;
  cloud.maxSigma = 3.5;
  cloud.maxLogWeight = 3;
  GaussianField field = randomField(gaussians, cloud, seed, Blending::Alpha, false);
  field.modelToWorld = {obliqueDirection(0.5), oblique().centre()};
  field.cutoff = 2.6;
  return field;
}

bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

} // namespace

TEST(Alpha, IsThePapersSumInDepthOrderAtEveryVoxel) {
  const GaussianField field = alphaField(300, 4);
  const GridGeometry geometry = oblique();
  const Affine3 toModel = inverse(field.modelToWorld), map = geometry.indexToWorld();
  const Affine3 modelToIndex = inverse(geometry.indexToWorld()) * field.modelToWorld;
  for (const std::string& set : instructionSets()) {
    RenderOptions options;
    options.instructionSet = set;
    const Volume volume = render(field, geometry, options);
    double largest = 0;
    for (std::size_t v = 0; v < volume.voxels.size(); v += 11) {
      const auto i = static_cast<std::int64_t>(v);
      const Vec3 index{double(i % 21), double(i / 21 % 18), double(i / (21 * 18))};
      const double expected = referenceValue(field, toModel(map(index)), modelToIndex);
      largest = std::max(largest, expected);
      ASSERT_NEAR(volume.voxels[v], expected, 1e-5) << set << ", voxel " << v;
    }
    EXPECT_GT(largest, 0.5);
  }
}

TEST(Alpha, OfOneGaussianAloneIsAdditive) {
  GaussianField alpha = alphaField(1, 9);
  alpha.gaussians[0].mean[0] = alpha.gaussians[0].mean[1] = alpha.gaussians[0].mean[2] = 0.3f;
  GaussianField additive = alpha;
  additive.blending = Blending::Additive;
  additive.gaussians[0].logWeight = -std::log1p(std::exp(-alpha.gaussians[0].logWeight));
  const Volume a = render(alpha, oblique()), b = render(additive, oblique());
  double largest = 0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    ASSERT_NEAR(a.voxels[v], b.voxels[v], 1e-6);
    largest = std::max<double>(largest, b.voxels[v]);
  }
  EXPECT_GT(largest, 0.01);
}

TEST(Alpha, NearestCentreComesFirstAndHidesWhatIsBehind) {
  GaussianField field;
  field.blending = Blending::Alpha;
  field.cutoff = 3;
  for (const float z : {-1.f, 1.f}) {
    Gaussian g{};
    g.mean[2] = z;
    std::fill_n(g.logScale, 3, std::log(3.f));
    g.quaternion[0] = 1;
    g.logWeight = 4; // α = 0.982
    g.intensity = z > 0 ? 1.f : 0.f;
    field.gaussians.push_back(g);
  }
  const auto sliceAt = [&](double z) { return render(field, grid(1, 1, 1, {1, 1, 1}, {0, 0, z})).voxels[0]; };
  EXPECT_GT(sliceAt(0.01), 0.85) << "the bright one is nearer";
  EXPECT_LT(sliceAt(-0.01), 0.15) << "the dark one is nearer";
  EXPECT_GT(sliceAt(0.01) - sliceAt(-0.01), 0.7) << "alpha blending jumps where the order swaps";
}

TEST(Alpha, PointsAreThoseOfSlicesAcrossTheModelsThirdAxis) {
  const GaussianField field = alphaField(200, 6);
  GridGeometry slice = grid(19, 17, 1, {0.9, 1.1, 1}, {0, 0, 0}, field.modelToWorld.linear);
  slice.origin = field.modelToWorld(Vec3{-8, -9, 1.7});
  const Volume volume = render(field, slice);
  const auto values = renderPoints(field, pointsOf(slice));
  for (std::size_t v = 0; v < values.size(); ++v)
    ASSERT_NEAR(values[v], volume.voxels[v], 1e-5);
}

TEST(Alpha, IsTheSameForAnyNumberOfThreadsAndTiles) {
  const GaussianField field = alphaField(500, 8);
  // Few planes are divided into tiles of rows, many are not.
  for (const std::int64_t planes : {1, 3, 13}) {
    GridGeometry geometry = oblique();
    geometry.size = {70, 90, planes};
    geometry.spacing = {0.3, 0.3, 1.5};
    const SampleGrid grid = sampleGridOf(geometry, field.modelToWorld);
    std::vector<float> images[3], gradients[3];
    for (int n = 0; n < 3; ++n) {
      ThreadPool pool(std::array{1, 2, 5}[n]);
      GridRenderer renderer(grid, kernelSet(""), pool);
      std::vector<float> t(grid.bufferSize()), r(grid.bufferSize(), 0.f);
      images[n].resize(grid.bufferSize());
      renderer.forward(field, {}, t.data(), images[n].data());
      Numbers random(3);
      for (int row = 0; row < grid.ny * grid.planes(); ++row)
        for (int x = 0; x < grid.nx; ++x)
          r[static_cast<std::size_t>(row) * grid.stride() + x] = static_cast<float>(random(-1, 1));
      gradients[n].assign(16 * field.gaussians.size(), 0.f);
      renderer.backward(field, r.data(), images[n].data(), gradients[n]);
    }
    for (int n = 1; n < 3; ++n) {
      EXPECT_TRUE(sameBits(images[n], images[0]));
      EXPECT_TRUE(sameBits(gradients[n], gradients[0]));
    }
    double size = 0;
    for (float g : gradients[0])
      size += std::fabs(g);
    EXPECT_GT(size, 1.0);
  }
}

class AlphaKernels : public ::testing::TestWithParam<std::tuple<int, Selection>> {
protected:
  void SetUp() override {
    grid.nx = std::get<0>(GetParam());
    grid.ny = 23;
    grid.z = {0.4};
    grid.indexToModel.linear = obliqueDirection(0.6);
    Numbers random(50 + grid.nx);
    GaussianField field;
    field.blending = Blending::Alpha;
    field.cutoff = 2.8;
    for (const double sigma : {0.05, 0.4, 1.0, 2.0, 5.0, 20.0}) {
      Cloud cloud;
      cloud.minSigma = 0.8 * sigma;
      cloud.maxSigma = 1.25 * sigma;
      cloud.maxLogWeight = 4;
      for (int i = 0; i < 20; ++i) {
        Gaussian g = randomGaussian(random, cloud);
        const Vec3 at =
            grid.indexToModel({random(-3, grid.nx + 3), random(-3, 26), 0.4 + 2 * sigma * random(-1, 1)});
        for (int a = 0; a < 3; ++a)
          g.mean[a] = static_cast<float>(at[a]);
        field.gaussians.push_back(g);
      }
    }
    project(field, {}, grid, {}, pool, projected, selection);
    ids.resize(projected.size());
    std::iota(ids.begin(), ids.end(), 0u);
  }

  GridView view() const { return {grid.nx, grid.ny, 1, grid.stride(), grid.z.data()}; }
  std::size_t tileSize() const { return static_cast<std::size_t>(tile.y1 - tile.y0) * grid.stride(); }

  struct Forward {
    std::vector<float> transmittance, image;
  };
  Forward forward(const KernelSet& set) const {
    Forward f{std::vector<float>(grid.bufferSize(), 1.f), std::vector<float>(grid.bufferSize(), 0.f)};
    set.composite(projected.data(), ids.data(), ids.size(), view(), tile, f.transmittance.data(),
                  f.image.data());
    return f;
  }

  const Selection selection = std::get<1>(GetParam());
  const TileRange tile{4, 19, 0, 1};
  ThreadPool pool{1};
  SampleGrid grid;
  std::vector<Projected> projected;
  std::vector<std::uint32_t> ids;
};

TEST_P(AlphaKernels, CompositeAsTheScalarSetAndOnlyInTheTile) {
  const Forward expected = forward(kernelSet("scalar", selection));
  int seen = 0;
  for (const KernelSet& set : kernelSets(selection)) {
    SCOPED_TRACE(set.name);
    EXPECT_EQ(set.selection, selection);
    const Forward got = forward(set);
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        const std::size_t v = static_cast<std::size_t>(y) * grid.stride() + x;
        ASSERT_NEAR(got.transmittance[v], expected.transmittance[v], 1e-6);
        ASSERT_NEAR(got.image[v], expected.image[v], 2e-6);
        if (y < tile.y0 || y >= tile.y1) {
          ASSERT_EQ(got.transmittance[v], 1.f);
          ASSERT_EQ(got.image[v], 0.f);
        } else {
          seen += got.image[v] > 0;
        }
      }
  }
  EXPECT_GT(seen, 0);
}

TEST_P(AlphaKernels, GradientAsTheScalarSet) {
  Numbers random(7);
  std::vector<float> r(grid.bufferSize(), 0.f);
  for (int y = 0; y < grid.ny; ++y)
    for (int x = 0; x < grid.nx; ++x)
      r[static_cast<std::size_t>(y) * grid.stride() + x] = static_cast<float>(random(-1, 1));
  const auto momentsOf = [&](const KernelSet& set) {
    const Forward f = forward(set);
    std::vector<float> seen(tileSize(), 1.f);
    const auto first = f.image.begin() + static_cast<std::ptrdiff_t>(tile.y0) * grid.stride();
    std::vector<float> rest(first, first + static_cast<std::ptrdiff_t>(tileSize()));
    std::vector<math::PlaneMoments<float>> out(ids.size());
    set.compositeBackward(projected.data(), ids.data(), ids.size(), view(), tile, r.data(), seen.data(),
                          rest.data(), out.data());
    return out;
  };
  constexpr int kCount = sizeof(math::PlaneMoments<float>) / sizeof(float);
  static_assert(kCount == 8);
  const auto expected = momentsOf(kernelSet("scalar", selection));
  double largest[kCount] = {};
  for (const auto& m : expected)
    for (int c = 0; c < kCount; ++c)
      largest[c] = std::max<double>(largest[c], std::fabs(reinterpret_cast<const float*>(&m)[c]));
  for (int c = 0; c < kCount; ++c)
    EXPECT_GT(largest[c], 0) << "moment " << c << " is never seen";
  for (const KernelSet& set : kernelSets(selection)) {
    const auto got = momentsOf(set);
    for (std::size_t i = 0; i < ids.size(); ++i)
      for (int c = 0; c < kCount; ++c) {
        const float e = reinterpret_cast<const float*>(&expected[i])[c];
        ASSERT_NEAR(reinterpret_cast<const float*>(&got[i])[c], e, 1e-4 * std::fabs(e) + 1e-4 * largest[c])
            << set.name << ", Gaussian " << i << ", moment " << c;
      }
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, AlphaKernels,
                         ::testing::Combine(::testing::Values(1, 15, 17, 40),
                                            ::testing::Values(Selection::Exact, Selection::Method1,
                                                              Selection::Method2)),
                         [](const auto& info) {
                           return std::to_string(std::get<0>(info.param)) +
                                  selectionName(std::get<1>(info.param));
                         });
