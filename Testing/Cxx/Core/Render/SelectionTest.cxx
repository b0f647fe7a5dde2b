#include "Core/Settings/Selection.h"
#include "Core/Render/Candidates.h"
#include "Core/Render/Render.h"
#include "RandomFields.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>
#include <set>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr Selection kAll[] = {Selection::Exact, Selection::Method1, Selection::Method2};

/// Oblique grid, unequal spacings, Gaussians with axis ratios up to 4.
struct Scene {
  Scene() {
    Cloud cloud;
    cloud.low = {2, 2, 2};
    cloud.high = {16, 14, 12};
    cloud.minSigma = 0.6;
    cloud.maxSigma = 2;
    cloud.anisotropy = 4;
    field = randomField(120, cloud, 12, Blending::Normalised, false);
    field.cutoff = 3;
    grid.nx = 19;
    grid.ny = 17;
    for (int k = 0; k < 14; ++k)
      grid.z.push_back(k);
    grid.indexToModel.linear = obliqueDirection(0.3) * diagonal({1, 0.9, 1.1});
    view = {grid.nx, grid.ny, 14, grid.stride(), grid.z.data()};
  }

  std::set<int> candidates(const Projected& g, Selection selection) const {
    std::set<int> found;
    forEachCandidateRow(g, view, selection, {0, grid.ny, 0, 14}, [&](int k, int y, int x0, int x1) {
      for (int x = x0; x < x1; ++x)
        EXPECT_TRUE(found.insert(x + grid.nx * (y + grid.ny * k)).second) << "visited twice";
    });
    return found;
  }

  std::vector<Projected> projected(Selection selection) {
    std::vector<Projected> all;
    project(field, {}, grid, {}, pool, all, selection);
    return all;
  }

  GaussianField field;
  SampleGrid grid;
  GridView view;
  ThreadPool pool{1};
};

/// Covariance in index coordinates, by its definition.
void indexCovariance(const Scene& scene, const Gaussian& g, double* s) {
  const Mat3 toIndex = inverse(scene.grid.indexToModel).linear;
  const double q[4] = {g.quaternion[0], g.quaternion[1], g.quaternion[2], g.quaternion[3]};
  double r[9], scaled[9], inIndex[9], a[9];
  math::rotation(q, r);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      scaled[3 * i + j] = r[3 * i + j] * std::exp(static_cast<double>(g.logScale[j]));
      a[3 * i + j] = toIndex[i][j];
    }
  math::multiply(a, scaled, inIndex);
  math::outer(inIndex, s);
}

/// Largest eigenvalue by power iteration.
double powerIteration(const double* s) {
  double v[3] = {1, 0.7, 0.4}, value = 0;
  for (int n = 0; n < 5000; ++n) {
    const double w[3] = {s[0] * v[0] + s[1] * v[1] + s[2] * v[2], s[1] * v[0] + s[3] * v[1] + s[4] * v[2],
                         s[2] * v[0] + s[4] * v[1] + s[5] * v[2]};
    value = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    for (int i = 0; i < 3; ++i)
      v[i] = w[i] / value;
  }
  return value;
}

} // namespace

TEST(Selection, LargestEigenvalueIsThatOfPowerIteration) {
  Scene scene;
  for (const Gaussian& g : scene.field.gaussians) {
    double s[6];
    indexCovariance(scene, g, s);
    EXPECT_NEAR(math::largestEigenvalue(s), powerIteration(s), 1e-6 * s[0] + 1e-6 * powerIteration(s));
  }
  const double ball[6] = {2, 0, 0, 2, 0, 2};
  EXPECT_DOUBLE_EQ(math::largestEigenvalue(ball), 2);
}

TEST(Selection, CandidatesAreWhatTheDefinitionsSay) {
  Scene scene;
  const Affine3 modelToIndex = inverse(scene.grid.indexToModel);
  int total[3] = {}, unsure[3] = {};
  for (const Selection selection : kAll) {
    const auto projected = scene.projected(selection);
    for (std::size_t n = 0; n < projected.size(); ++n) {
      const Gaussian& g = scene.field.gaussians[n];
      const Vec3 mean = modelToIndex({g.mean[0], g.mean[1], g.mean[2]});
      double s[6], precision[6];
      indexCovariance(scene, g, s);
      std::copy_n(s, 6, precision);
      math::invertSymmetric(s, precision);
      const auto slice = math::sliceConditional(s);
      const double spread = slice.covariance[0] - slice.covariance[2];
      const double lambda = 0.5 * (slice.covariance[0] + slice.covariance[2]) +
                            std::sqrt(0.25 * spread * spread + slice.covariance[1] * slice.covariance[1]);
      const double cube = 3 * std::sqrt(powerIteration(s));
      const auto found = scene.candidates(projected[n], selection);
      for (int k = 0; k < 14; ++k)
        for (int y = 0; y < scene.grid.ny; ++y)
          for (int x = 0; x < scene.grid.nx; ++x) {
            const double d[3] = {x - mean[0], y - mean[1], k - mean[2]};
            double excess; // > 0: not a candidate; in units of the limit
            if (selection == Selection::Exact) {
              const double m =
                  precision[0] * d[0] * d[0] + precision[3] * d[1] * d[1] + precision[5] * d[2] * d[2] +
                  2 * (precision[1] * d[0] * d[1] + precision[2] * d[0] * d[2] + precision[4] * d[1] * d[2]);
              excess = std::sqrt(m) / 3 - 1;
            } else if (selection == Selection::Method1) {
              excess = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) / cube - 1;
            } else {
              const double p = std::exp(-0.5 * d[2] * d[2] / slice.variance);
              const double half = 3 * std::sqrt(lambda) * std::sqrt(p);
              excess = std::max({std::abs(d[0] - slice.shift[0] * d[2]) / half - 1,
                                 std::abs(d[1] - slice.shift[1] * d[2]) / half - 1,
                                 std::abs(d[2]) / (3 * std::sqrt(slice.variance)) - 1});
            }
            const int which = static_cast<int>(selection);
            const bool candidate = found.count(x + scene.grid.nx * (y + scene.grid.ny * k)) > 0;
            total[which] += candidate;
            if (std::abs(excess) < 1e-3) {
              ++unsure[which]; // within rounding of the limit
              continue;
            }
            ASSERT_EQ(candidate, excess < 0)
                << selectionName(selection) << " Gaussian " << n << " at " << x << " " << y << " " << k;
          }
    }
  }
  for (int s = 0; s < 3; ++s) {
    EXPECT_GT(total[s], 1000);
    EXPECT_LT(unsure[s], total[s] / 50);
  }
}

TEST(Selection, Method1ContainsExact) {
  Scene scene;
  const auto exact = scene.projected(Selection::Exact), cube = scene.projected(Selection::Method1);
  std::size_t inside = 0, more = 0;
  for (std::size_t n = 0; n < exact.size(); ++n) {
    const auto small = scene.candidates(exact[n], Selection::Exact),
               large = scene.candidates(cube[n], Selection::Method1);
    EXPECT_TRUE(std::includes(large.begin(), large.end(), small.begin(), small.end())) << "Gaussian " << n;
    inside += small.size();
    more += large.size();
  }
  EXPECT_GT(more, 2 * inside);
}

// Voxels exactly on the rim: round Gaussians on voxel centres, with radii that end on voxels.
TEST(Selection, Method1ContainsExactOnTheRim) {
  Scene scene;
  scene.grid.indexToModel = {};
  scene.field.gaussians.clear();
  Numbers random(31);
  for (int n = 0; n < 300; ++n) {
    Gaussian g = randomGaussian(random, {});
    for (int a = 0; a < 3; ++a) {
      g.mean[a] = std::floor(static_cast<float>(random(5, 12)));
      g.logScale[a] = static_cast<float>(std::log((1 + n % 12) / 3.0)); // 3σ = 1…12 voxels
    }
    scene.field.gaussians.push_back(g);
  }
  const auto exact = scene.projected(Selection::Exact), cube = scene.projected(Selection::Method1);
  for (std::size_t n = 0; n < exact.size(); ++n) {
    const auto small = scene.candidates(exact[n], Selection::Exact),
               large = scene.candidates(cube[n], Selection::Method1);
    EXPECT_TRUE(std::includes(large.begin(), large.end(), small.begin(), small.end())) << "Gaussian " << n;
  }
}

// Its square contains the ellipse while r² ≤ 2 + 2·ln 4.5.
TEST(Selection, Method2MissesNothingUpToItsRadius) {
  Cloud cloud;
  GaussianField field = randomField(150, cloud, 3, Blending::Additive, false);
  const GridGeometry geometry = grid(40, 40, 40, {0.4, 0.4, 0.4}, {-8, -8, -8});
  for (const double cutoff : {2.2, 2.236}) {
    field.cutoff = cutoff;
    RenderOptions options;
    const Volume exact = render(field, geometry, options);
    options.selection = Selection::Method2;
    const Volume method2 = render(field, geometry, options);
    for (std::size_t v = 0; v < exact.voxels.size(); ++v)
      ASSERT_NEAR(method2.voxels[v], exact.voxels[v], 1e-5) << cutoff;
  }
}

// Selections that miss nothing render the same image, in every blending; Method 2 misses something.
TEST(Selection, OnlyMethod2ChangesTheImage) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
    Cloud cloud;
    cloud.maxSigma = 2;
    GaussianField field = randomField(150, cloud, 3, blending, false);
    field.cutoff = 3;
    const GridGeometry geometry = grid(15, 16, 14, {1, 1.1, 0.9}, {-7, -8, -6});
    for (const std::string& set : instructionSets()) {
      RenderOptions options;
      options.instructionSet = set;
      const Volume exact = render(field, geometry, options);
      options.selection = Selection::Method1;
      const Volume method1 = render(field, geometry, options);
      options.selection = Selection::Method2;
      const Volume method2 = render(field, geometry, options);
      double range = 0, lost = 0;
      for (std::size_t v = 0; v < exact.voxels.size(); ++v) {
        range = std::max<double>(range, std::fabs(exact.voxels[v]));
        lost = std::max<double>(lost, std::fabs(exact.voxels[v] - method2.voxels[v]));
      }
      for (std::size_t v = 0; v < exact.voxels.size(); ++v)
        ASSERT_NEAR(method1.voxels[v], exact.voxels[v], 1e-5 * range) << blendingName(blending) << " " << set;
      EXPECT_GT(lost, 1e-4 * range) << blendingName(blending) << " " << set;
    }
  }
}

TEST(Selection, KernelsOfAllSetsRenderAsTheScalarOne) {
  for (const Selection selection : kAll)
    for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
      Cloud cloud;
      const GaussianField field = randomField(100, cloud, 5, blending, false);
      const GridGeometry geometry = grid(37, 16, 14, {0.5, 1.1, 0.9}, {-9, -8, -6});
      RenderOptions options;
      options.selection = selection;
      options.instructionSet = "scalar";
      const Volume expected = render(field, geometry, options);
      for (const std::string& set : instructionSets()) {
        options.instructionSet = set;
        const Volume got = render(field, geometry, options);
        for (std::size_t v = 0; v < got.voxels.size(); ++v)
          ASSERT_NEAR(got.voxels[v], expected.voxels[v], 2e-5)
              << selectionName(selection) << " " << blendingName(blending) << " " << set;
      }
    }
}
