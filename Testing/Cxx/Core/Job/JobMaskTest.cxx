#include "Core/Job/JobInput.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "JobInputs.h"

#include <algorithm>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr float kFill = -321;

Mask ball(double radius) {
  const Vec3 centre = smallGrid().centre() + Vec3{2, 1, -1};
  return maskInSpace(smallGrid(), [&](const Vec3& x) { return norm(x - centre) < radius; });
}

ReconstructionInput maskedInput() {
  ReconstructionInput input = anisotropicInput();
  input.masks = {ball(6)};
  return input;
}

Settings filled(int iterations = 10) {
  Settings settings = quickSettings(iterations);
  settings.fill = kFill;
  return settings;
}

/// A dark and a bright half, at whose border fields overshoot.
ReconstructionInput stepInput() {
  const Volume step = volumeOf(smallGrid(), [](auto i, auto j, auto) { return i < 12 || j > 17 ? 0 : 1000; });
  return inputOf({simulateThickStack(step, 2, 4)});
}

void expectWithin(const std::vector<float>& values, float low, float high) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  EXPECT_GE(*least, low);
  EXPECT_LE(*most, high);
}

} // namespace

TEST(MaskedJob, GivesTheFillValueBeyondTheMasksMargin) {
  const ReconstructionInput input = maskedInput();
  const auto result = reconstruct(input, filled());
  const GaussianField& field = result.model->field;
  const Volume whole = render(field, smallGrid());
  const double margin = input.stacks[0].image.geometry.spacing[2];
  EXPECT_EQ(margin, 4);
  const std::vector<Vec3> all = pointsOf(smallGrid());
  std::vector<Vec3> inside;
  for (std::size_t v = 0; v < all.size(); ++v)
    if (input.masks.front().voxels[v]) inside.push_back(all[v]);
  int around = 0;
  for (std::size_t v = 0; v < all.size(); ++v) {
    double nearest = 1e300;
    for (const Vec3& x : inside)
      nearest = std::min(nearest, norm(x - all[v]));
    if (nearest > margin + 1e-6) {
      ASSERT_EQ(whole.voxels[v], kFill) << nearest << " mm from the mask";
    } else if (nearest == 0) {
      ASSERT_NE(whole.voxels[v], kFill);
    } else {
      around += whole.voxels[v] != kFill;
    }
  }
  EXPECT_GT(around, 200);
}

TEST(MaskedJob, CutsTheGridToTheMasksBoxUnlessOneIsGiven) {
  ReconstructionInput input = maskedInput();
  const auto result = reconstruct(input, filled());
  const GridGeometry& cut = result.volume.geometry;
  EXPECT_TRUE(sameGrid(cut, result.model->field.support.geometry, 1e-9));
  EXPECT_LT(cut.voxelCount(), smallGrid().voxelCount());
  const Vec3 first = inverse(smallGrid().indexToWorld())(cut.origin);
  std::array<std::int64_t, 3> begin;
  for (int a = 0; a < 3; ++a)
    EXPECT_NEAR(first[a], static_cast<double>(begin[a] = std::llround(first[a])), 1e-9)
        << "same voxel centres";
  EXPECT_EQ(cropped(smallGrid(), begin, cut.size).size, cut.size);
  input.outputGrid = smallGrid();
  const auto given = reconstruct(input, filled());
  EXPECT_EQ(given.volume.geometry, smallGrid());
  EXPECT_EQ(given.volume.voxels, render(given.model->field, smallGrid()).voxels);
  input.cropToMask = true;
  EXPECT_TRUE(sameGrid(reconstruct(input, filled()).volume.geometry, cut, 1e-9));
}

TEST(MaskedJob, StaysWithinTheMaskedRange) {
  ReconstructionInput input = maskedInput();
  float low = 1e9f, high = -1e9f;
  for (Stack& stack : input.stacks)
    for (std::int64_t v = 0; v < stack.image.geometry.voxelCount(); ++v)
      stack.image.voxels[v] = std::max(stack.image.voxels[v], 60.f);
  const auto result = reconstruct(input, filled(20));
  const auto range = result.model->field.range;
  ASSERT_TRUE(range);
  EXPECT_TRUE(sameGrid(result.model->field.residual.geometry, result.model->field.support.geometry, 1e-6))
      << "refined where the mask is alone";
  EXPECT_GE(range->low, 60);
  for (const float v : result.volume.voxels)
    if (v != kFill) low = std::min(low, v), high = std::max(high, v);
  EXPECT_GE(low, range->low);
  EXPECT_LE(high, range->high);
  EXPECT_GT(high, low);
}

TEST(MaskedJob, FitsEachScanInsideItsOwnMask) {
  ReconstructionInput input = orthogonalInput();
  input.masks = {ball(6), ball(4)};
  const PreparedInput prepared = prepareInput(input);
  for (int s = 0; s < 2; ++s)
    EXPECT_EQ(prepared.stacks[s].observed, resampleMask(input.masks[s], input.stacks[s].image.geometry));
  ReconstructionInput one = input, twice = input;
  one.masks = {ball(6)};
  twice.masks = {ball(6), ball(6)};
  const GaussianField expected = reconstruct(one, filled()).model->field;
  EXPECT_TRUE(sameField(reconstruct(twice, filled()).model->field, expected))
      << "one for all is one for each";
  EXPECT_FALSE(sameField(reconstruct(input, filled()).model->field, expected));
}

TEST(MaskedJob, MovesAMaskWithItsScan) {
  ReconstructionInput input = orthogonalInput();
  input.masks = {ball(6), ball(6)};
  const Vec3 off{-9, 0, 0}; // of the second scan and its mask
  for (GridGeometry* g : {&input.stacks[1].image.geometry, &input.masks[1].geometry})
    g->origin = g->origin + off;
  const auto back = [&](std::span<Stack> stacks) {
    stacks[1].image.geometry.origin = stacks[1].image.geometry.origin - off;
    return std::vector<std::string>{};
  };
  ReconstructionInput together = orthogonalInput();
  together.masks = {ball(6)};
  const Mask expected = prepareInput(together).support;
  const PreparedInput aligned = prepareInput(input, {}, false, back);
  EXPECT_EQ(aligned.support.voxels, expected.voxels);
  EXPECT_TRUE(sameGrid(aligned.support.geometry, expected.geometry, 1e-6));
  EXPECT_GT(prepareInput(input).support.geometry.voxelCount(), expected.geometry.voxelCount())
      << "nothing to move";
}

TEST(MaskedJob, GoesOnWhereItWasStopped) {
  const ReconstructionInput input = maskedInput();
  const auto straight = reconstruct(input, filled(12));
  const auto stopped = stoppedAt(5, input, filled(12));
  ASSERT_TRUE(stopped.cancelled);
  ReconstructionInput on = input;
  on.resume = stopped.model;
  const auto resumed = reconstruct(on, filled(12));
  EXPECT_TRUE(sameField(resumed.model->field, straight.model->field));
  EXPECT_EQ(resumed.volume.voxels, straight.volume.voxels);
  EXPECT_EQ(resumed.model->field.support.voxels, straight.model->field.support.voxels);
  // The value outside is not part of the fit: changing it does not restart the fit.
  on.resume = straight.model;
  Settings other = filled(12);
  other.fill = 9;
  const auto again = reconstruct(on, other);
  EXPECT_EQ(again.iterationsRun, 0);
  EXPECT_EQ(again.model->field.fill, 9);
}

TEST(ValueRange, OfAStepEdgeIsKept) {
  const auto result = reconstruct(stepInput(), quickSettings(30));
  GaussianField field = result.model->field;
  ASSERT_FALSE(field.residual.voxels.empty());
  expectWithin(result.volume.voxels, 0, 1000);
  for (float& v : field.residual.voxels) // a residual to keep
    v *= 5;
  RenderOptions unbounded;
  unbounded.bounded = false;
  const std::vector<float> free = render(field, field.domain, unbounded).voxels;
  const auto [least, most] = std::minmax_element(free.begin(), free.end());
  EXPECT_TRUE(*least < -10 || *most > 1010) << "nothing to keep";
  GridGeometry fine = withSpacing(field.domain, {0.7, 0.7, 0.7});
  expectWithin(render(field, fine).voxels, 0, 1000);
  expectWithin(renderStack(field, stepInput().stacks[0]).voxels, 0, 1000);
  expectWithin(renderPoints(field, pointsOf(field.domain)), 0, 1000);
  std::vector<float> plane(64 * 64);
  Affine3 oblique{obliqueDirection(0.8), field.domain.centre()};
  oblique.offset = oblique({-32, -32, 0});
  PlaneSampler(std::make_shared<const GaussianField>(field)).sample(oblique, 64, 64, plane);
  expectWithin(plane, std::min(0.f, float(field.intensityOffset)), 1000);
}

TEST(ValueRange, HoldsInHolesOfBrokenVoxels) {
  ReconstructionInput input = isotropicInput();
  Volume& image = input.stacks[0].image;
  const auto& n = image.geometry.size;
  for (std::int64_t k = 6; k < 13; ++k)
    for (std::int64_t j = 6; j < 14; ++j)
      for (std::int64_t i = 2; i < 12; ++i)
        image.voxels[i + n[0] * (j + n[1] * k)] = std::numeric_limits<float>::quiet_NaN();
  Settings settings = quickSettings(40);
  settings.gaussians = 1500;
  const auto result = reconstruct(input, settings);
  const ValueRange range = observedRange(input.stacks);
  expectWithin(result.volume.voxels, range.low, range.high);
}
