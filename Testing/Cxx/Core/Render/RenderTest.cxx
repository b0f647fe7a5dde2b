#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "RandomFields.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A few hundred anisotropic Gaussians around the grid's centre, with values in about [0, 1], in a separate
/// frame.
GaussianField fieldOn(const GridGeometry& geometry, Blending blending, bool linear) {
  Cloud cloud;
  cloud.low = {-11, -11, -11};
  cloud.high = {11, 11, 11};
  cloud.minSigma = 0.7;
  cloud.maxSigma = 3;
  GaussianField field = randomField(400, cloud, 31, blending, linear);
  field.modelToWorld = {obliqueDirection(0.5), geometry.centre()};
  field.intensityScale = 1;
  if (blending == Blending::Additive)
    for (Gaussian& g : field.gaussians)
      g.intensity *= 0.2f;
  return field;
}

GridGeometry obliqueGrid() {
  return grid(17, 14, 12, {1.0, 1.2, 1.5}, {30, -20, 55}, obliqueDirection(0.8));
}

double rangeOf(const Volume& volume) {
  const auto [low, high] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
  return *high - *low;
}

struct Way {
  const char* name;
  Blending blending;
  bool linear;
};

} // namespace

class Rendering : public ::testing::TestWithParam<Way> {
protected:
  GaussianField field = fieldOn(obliqueGrid(), GetParam().blending, GetParam().linear);
};

TEST_P(Rendering, IsTheFieldsFormulaAtEveryVoxel) {
  const GridGeometry geometry = obliqueGrid();
  const Volume volume = render(field, geometry);
  const double range = rangeOf(volume);
  EXPECT_GT(range, 0.3);
  const Affine3 toModel = inverse(field.modelToWorld);
  const auto points = pointsOf(geometry);
  for (std::size_t v = 0; v < points.size(); v += 7)
    ASSERT_NEAR(volume.voxels[v], referenceValue(field, toModel(points[v])), 1e-5 * range) << "voxel " << v;
}

TEST_P(Rendering, OfOnePointAgreesThroughEverySlicing) {
  const GridGeometry geometry = obliqueGrid();
  const Volume volume = render(field, geometry);
  const double tolerance = 1e-5 * rangeOf(volume);
  const Affine3 map = geometry.indexToWorld();

  const auto points = renderPoints(field, pointsOf(geometry));
  for (std::size_t v = 0; v < points.size(); ++v)
    ASSERT_NEAR(points[v], volume.voxels[v], tolerance) << "point " << v;

  // Single slices along every grid axis: axial, coronal, sagittal of this grid; two of them are
  // left-handed.
  for (int axis = 0; axis < 3; ++axis) {
    const Volume turned = withSliceAxis(volume, axis);
    for (std::int64_t k = 0; k < turned.geometry.size[2]; ++k) {
      const GridGeometry slice =
          cropped(turned.geometry, {0, 0, k}, {turned.geometry.size[0], turned.geometry.size[1], 1});
      const Volume rendered = render(field, slice);
      const std::size_t first = static_cast<std::size_t>(k) * rendered.voxels.size();
      for (std::size_t v = 0; v < rendered.voxels.size(); ++v)
        ASSERT_NEAR(rendered.voxels[v], turned.voxels[first + v], tolerance)
            << "axis " << axis << " slice " << k;
    }
  }

  // Oblique slices through voxels of the volume; each slice's points must match the point query.
  Numbers random(3);
  for (int n = 0; n < 12; ++n) {
    const std::int64_t at[3] = {n % 17, (3 * n) % 14, (5 * n) % 12};
    GridGeometry slice =
        grid(24, 19, 1, {0.7, 0.9, 1}, {0, 0, 0}, obliqueDirection(random(-3, 3), n % 2 == 1));
    const std::int64_t i = 10 + n % 5, j = 8;
    const Vec3 voxel = map({double(at[0]), double(at[1]), double(at[2])});
    slice.origin = voxel - slice.direction * Vec3{0.7 * i, 0.9 * j, 0};
    const Volume rendered = render(field, slice);
    ASSERT_NEAR(rendered.voxels[i + 24 * j], volume.voxels[at[0] + 17 * (at[1] + 14 * at[2])], tolerance);
    const auto queried = renderPoints(field, pointsOf(slice));
    for (std::size_t v = 0; v < queried.size(); ++v)
      ASSERT_NEAR(queried[v], rendered.voxels[v], tolerance);
  }
}

TEST_P(Rendering, OfAMirroredAndPermutedGridIsTheSameImage) {
  const GridGeometry geometry = obliqueGrid();
  const Volume volume = render(field, geometry);
  GridGeometry mirrored = geometry; // I reversed: left-handed
  mirrored.origin = geometry.indexToWorld()({double(geometry.size[0] - 1), 0, 0});
  for (int row = 0; row < 3; ++row)
    mirrored.direction[row][0] = -geometry.direction[row][0];
  const Volume other = render(field, mirrored);
  const double tolerance = 1e-5 * rangeOf(volume);
  for (std::int64_t r = 0; r < 14 * 12; ++r)
    for (std::int64_t i = 0; i < 17; ++i)
      ASSERT_NEAR(other.voxels[17 * r + i], volume.voxels[17 * r + 16 - i], tolerance);
}

TEST_P(Rendering, IsTheSameForAnyNumberOfThreads) {
  RenderOptions options;
  options.threads = 1;
  const Volume one = render(field, obliqueGrid(), options);
  const auto pointsOne = renderPoints(field, pointsOf(obliqueGrid()), options);
  for (int threads : {2, 3, 5}) {
    options.threads = threads;
    EXPECT_EQ(render(field, obliqueGrid(), options).voxels, one.voxels);
    EXPECT_EQ(renderPoints(field, pointsOf(obliqueGrid()), options), pointsOne);
  }
}

TEST_P(Rendering, AgreesBetweenInstructionSets) {
  RenderOptions options;
  options.instructionSet = "scalar";
  const Volume scalar = render(field, obliqueGrid(), options);
  for (const std::string& name : instructionSets()) {
    options.instructionSet = name;
    const Volume volume = render(field, obliqueGrid(), options);
    for (std::size_t v = 0; v < scalar.voxels.size(); ++v)
      ASSERT_NEAR(volume.voxels[v], scalar.voxels[v], 1e-5 * rangeOf(scalar)) << name;
  }
}

TEST_P(Rendering, AppliesTheIntensityMapOnlyWhenAsked) {
  field.intensityScale = 250;
  field.intensityOffset = -1024;
  RenderOptions plain;
  plain.scannerUnits = false;
  const Volume scanner = render(field, obliqueGrid()), normalised = render(field, obliqueGrid(), plain);
  for (std::size_t v = 0; v < scanner.voxels.size(); ++v)
    ASSERT_NEAR(scanner.voxels[v], 250 * normalised.voxels[v] - 1024, 1e-3);
  EXPECT_NEAR(renderPoints(field, pointsOf(obliqueGrid())).at(5), scanner.voxels[5], 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Blendings, Rendering,
                         ::testing::Values(Way{"Normalised", Blending::Normalised, false},
                                           Way{"NormalisedLinear", Blending::Normalised, true},
                                           Way{"Additive", Blending::Additive, false}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(RenderingOfAConstant, IsExactlyThatConstantWhereCovered) {
  GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, false);
  for (Gaussian& g : field.gaussians)
    g.intensity = 0.625f;
  const std::vector<float> ones(field.gaussians.size(), 1.f);
  RenderOptions coverage;
  coverage.values = ones;
  const Volume image = render(field, obliqueGrid()), covered = render(field, obliqueGrid(), coverage);
  std::int64_t voxels = 0;
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    // The constant is multiplied by the ratio Σ w p / (Σ w p + ε), which must add no texture.
    ASSERT_NEAR(image.voxels[v], 0.625f * covered.voxels[v], 1e-6);
    if (covered.voxels[v] < 0.999) continue;
    ++voxels;
    ASSERT_NEAR(image.voxels[v], 0.625, 0.625 * 1e-3);
  }
  EXPECT_GT(voxels, 500);
  field.epsilon = 1e-9;
  const Volume exact = render(field, obliqueGrid());
  for (std::size_t v = 0; v < exact.voxels.size(); ++v)
    if (covered.voxels[v] > 0.1) {
      ASSERT_NEAR(exact.voxels[v], 0.625, 1e-6);
    }
}

TEST(RenderingOfAStack, IntegratesTheFieldOverTheSliceProfile) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive})
    for (const SliceProfile profile : {SliceProfile::Point, SliceProfile::Box, SliceProfile::Gaussian}) {
      SCOPED_TRACE(static_cast<int>(blending) * 10 + static_cast<int>(profile));
      GaussianField field = fieldOn(obliqueGrid(), blending, blending == Blending::Normalised);
      field.intensityScale = 100;
      field.cutoff = 6; // removes the effect of the cut-off
      Stack stack;
      stack.image.geometry =
          grid(9, 8, 4, {1.1, 1.3, 3}, obliqueGrid().centre() - Vec3{5, 5, 5}, obliqueDirection(-0.6));
      stack.image.voxels.assign(stack.image.geometry.voxelCount(), 0.f);
      stack.profile = profile;
      stack.thickness = 3.3;
      const Volume rendered = renderStack(field, stack);
      const Affine3 map = stack.image.geometry.indexToWorld();
      const Vec3 normal = column(stack.image.geometry.direction, 2);
      // The profile by brute force: 201 points per voxel.
      std::vector<Vec3> points;
      std::vector<double> weights;
      const double tau = 3.3 / 2.3548200450309493;
      for (std::int64_t v = 0; v < stack.image.geometry.voxelCount(); v += 5)
        for (int n = -100; n <= 100; ++n) {
          if (profile == SliceProfile::Point && n != 0) continue;
          const double t = n / 100.0 * (profile == SliceProfile::Box ? 1.65 : 4 * tau);
          points.push_back(map({double(v % 9), double(v / 9 % 8), double(v / 72)}) + t * normal);
          weights.push_back(profile == SliceProfile::Box ? (std::abs(n) == 100 ? 0.5 : 1)
                                                         : std::exp(-0.5 * t * t / (tau * tau)));
        }
      const auto values = renderPoints(field, points);
      const double range = rangeOf(rendered);
      const std::size_t each = profile == SliceProfile::Point ? 1 : 201;
      double worst = 0;
      for (std::size_t n = 0; n < values.size() / each; ++n) {
        double sum = 0, total = 0;
        for (std::size_t m = n * each; m < (n + 1) * each; ++m)
          sum += weights[m] * values[m], total += weights[m];
        worst = std::max(worst, std::abs(rendered.voxels[5 * n] - sum / total));
      }
      const bool closedForm = profile == SliceProfile::Gaussian && blending == Blending::Additive;
      EXPECT_LT(worst, range * (profile == SliceProfile::Point ? 1e-5 : closedForm ? 1e-3 : 0.02));
    }
}

TEST(RenderingOfAStack, FollowsThePosesOfItsSlices) {
  const GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true);
  Stack stack;
  stack.image.geometry = cropped(obliqueGrid(), {0, 0, 2}, {17, 14, 5});
  stack.image.voxels.assign(stack.image.geometry.voxelCount(), 0.f);
  stack.profile = SliceProfile::Point;
  for (int k = 0; k < 5; ++k)
    stack.poses.push_back({obliqueDirection(0.02 * k), Vec3{0.3 * k, -0.2 * k, 5.0 * (k % 2)}});
  const Volume rendered = renderStack(field, stack);
  const auto points = pointsOf(stack.image.geometry);
  std::vector<Vec3> moved;
  for (std::size_t v = 0; v < points.size(); ++v)
    moved.push_back(stack.poses[v / (17 * 14)](points[v]));
  const auto expected = renderPoints(field, moved);
  for (std::size_t v = 0; v < points.size(); ++v)
    ASSERT_NEAR(rendered.voxels[v], expected[v], 1e-5);
}

TEST(RenderingOfDetail, StacksShowWhatPointsDo) {
  GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true);
  field.residual = randomVolume(obliqueGrid(), -0.3, 0.3, 5);
  const auto between = [](const Vec3& shift) { // voxels of the grid
    GridGeometry g = obliqueGrid();
    g.origin = g.indexToWorld()(shift);
    return g;
  };
  Stack onVoxels, shifted, posed;
  onVoxels.image.geometry = obliqueGrid();
  shifted.image.geometry = posed.image.geometry = between({0.4, -0.3, 0.5});
  for (std::int64_t k = 0; k < posed.image.geometry.size[2]; ++k)
    posed.poses.push_back({obliqueDirection(0.01 * k), Vec3{0.3, -0.2, 0.1 * k}});
  for (Stack* stack : {&onVoxels, &shifted, &posed}) {
    const GridGeometry& g = stack->image.geometry;
    stack->image.voxels.assign(g.voxelCount(), 0.f);
    stack->profile = SliceProfile::Point;
    const Volume rendered = renderStack(field, *stack);
    auto points = pointsOf(g);
    for (std::size_t v = 0; v < points.size() && !stack->poses.empty(); ++v)
      points[v] = stack->poses[v / (g.size[0] * g.size[1])](points[v]);
    const auto expected = renderPoints(field, points);
    for (std::size_t v = 0; v < points.size(); ++v)
      ASSERT_NEAR(rendered.voxels[v], expected[v], 2e-5) << v;
  }
}

TEST(RenderingOfDetail, AddsItInsideItsBoxThroughEveryPath) {
  GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true);
  field.domain = obliqueGrid();
  const GaussianField plain = field;
  field.residual = randomVolume(
      grid(9, 8, 7, {1.5, 1.3, 1.4}, obliqueGrid().centre() - Vec3{5, 4, 5}, obliqueDirection(-0.2)), -0.3,
      0.3, 4);
  EXPECT_NO_THROW(checkField(field));
  const Volume with = render(field, obliqueGrid()), without = render(plain, obliqueGrid());
  const auto points = pointsOf(obliqueGrid());
  const auto queried = renderPoints(field, points);
  const Affine3 toIndex = inverse(field.residual.geometry.indexToWorld());
  int inside = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Vec3 x = toIndex(points[v]);
    bool in = true;
    for (int a = 0; a < 3; ++a)
      in = in && x[a] >= -0.5 && x[a] <= static_cast<double>(field.residual.geometry.size[a]) - 0.5;
    inside += in;
    const double expected = without.voxels[v] + (in ? sampleCubic(field.residual, x) : 0);
    ASSERT_NEAR(with.voxels[v], expected, 1e-5);
    ASSERT_NEAR(queried[v], expected, 1e-5);
  }
  EXPECT_GT(inside, 300);
  EXPECT_LT(inside, static_cast<int>(points.size()) - 300);
  // Another channel has no residual grid.
  const std::vector<float> ones(field.gaussians.size(), 1.f);
  RenderOptions channel;
  channel.values = ones;
  EXPECT_EQ(render(field, obliqueGrid(), channel).voxels, render(plain, obliqueGrid(), channel).voxels);
  field.residual.voxels.pop_back();
  EXPECT_THROW(checkField(field), Error);
}

TEST(RenderingOfADomain, EndsAtItsBoxThroughEveryPath) {
  for (const double offset : {0.0, -1024.0}) {
    GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true), unlimited = field;
    field.intensityOffset = unlimited.intensityOffset = offset;
    field.domain =
        grid(8, 7, 6, {1.1, 1.2, 1.3}, obliqueGrid().centre() - Vec3{2, 3, 4}, obliqueDirection(1.1, true));
    const Affine3 toDomain = inverse(field.domain.indexToWorld());
    const auto margin = [&](const Vec3& x) { // > 0 inside, in voxels of the domain
      const Vec3 at = toDomain(x);
      double nearest = 1e9;
      for (int a = 0; a < 3; ++a)
        nearest = std::min({nearest, at[a] + 0.5, static_cast<double>(field.domain.size[a]) - 0.5 - at[a]});
      return nearest;
    };
    const Volume volume = render(field, obliqueGrid());
    for (int axis = 0; axis < 3; ++axis) {
      const Volume turned = withSliceAxis(volume, axis);
      const Volume limited = render(field, turned.geometry), whole = render(unlimited, turned.geometry);
      const auto points = pointsOf(turned.geometry);
      const auto queried = renderPoints(field, points);
      int inside = 0;
      for (std::size_t v = 0; v < points.size(); ++v) {
        const double m = margin(points[v]);
        if (std::abs(m) < 1e-3) continue; // on the edge itself, rounding decides
        inside += m > 0;
        ASSERT_NEAR(limited.voxels[v], m > 0 ? whole.voxels[v] : offset, 2e-4) << "axis " << axis;
        ASSERT_NEAR(queried[v], limited.voxels[v], 2e-4);
        ASSERT_NEAR(turned.voxels[v], limited.voxels[v], 2e-4);
      }
      EXPECT_GT(inside, 100);
    }
  }
}

TEST(RenderingErrors, AreRefusedInASentence) {
  const GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true);
  RenderOptions options;
  const std::vector<float> three(3, 1.f);
  options.values = three;
  EXPECT_EQ(test::codeOf([&] { render(field, obliqueGrid(), options); }), ErrorCode::InvalidArgument);
  const std::vector<Vec3> one{{0, 0, 0}}, nowhere{{0, std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_EQ(test::codeOf([&] { renderPoints(field, one, options); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(test::codeOf([&] { renderPoints(field, nowhere); }), ErrorCode::InvalidArgument);
  GridGeometry broken = obliqueGrid();
  broken.spacing[1] = 0;
  EXPECT_EQ(test::codeOf([&] { render(field, broken); }), ErrorCode::Geometry);
  RenderOptions unknown;
  unknown.instructionSet = "MMX";
  EXPECT_EQ(test::codeOf([&] { render(field, obliqueGrid(), unknown); }), ErrorCode::InvalidArgument);
  std::stop_source source;
  source.request_stop();
  RenderOptions stopped;
  stopped.stop = source.get_token();
  EXPECT_EQ(test::codeOf([&] { render(field, obliqueGrid(), stopped); }), ErrorCode::Cancelled);
  EXPECT_EQ(test::codeOf([&] { renderPoints(field, pointsOf(obliqueGrid()), stopped); }),
            ErrorCode::Cancelled);
}

TEST(RenderingOfPoints, AcceptsNoneOneAndManyInAPlane) {
  const GaussianField field = fieldOn(obliqueGrid(), Blending::Normalised, true);
  EXPECT_TRUE(renderPoints(field, {}).empty());
  const Vec3 centre = obliqueGrid().centre();
  const Affine3 toModel = inverse(field.modelToWorld);
  const auto one = renderPoints(field, std::vector<Vec3>{centre});
  EXPECT_NEAR(one.at(0), referenceValue(field, toModel(centre)), 1e-5);
  const auto same = renderPoints(field, std::vector<Vec3>(5, centre));
  for (float v : same)
    EXPECT_NEAR(v, one.at(0), 1e-6);
  // Far away nothing contributes, and a distant point must not affect the others.
  const auto mixed = renderPoints(field, std::vector<Vec3>{centre, centre + Vec3{50000, 0, 0}});
  EXPECT_NEAR(mixed.at(0), one.at(0), 1e-4);
  EXPECT_EQ(mixed.at(1), 0.f);
}
