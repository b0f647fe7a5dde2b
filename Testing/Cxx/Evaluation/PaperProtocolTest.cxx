#include "Evaluation/PaperProtocol.h"
#include "Core/Base/Error.h"
#include "Core/Render/Render.h"

#include "../Core/TestVolumes.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

using namespace innergs;
using namespace innergs::testing;

TEST(PaperProtocol, HoldsOutFivePercentOfEachPlaneBySeed) {
  const Volume truth = randomVolume(grid(40, 60, 80), 0, 100);
  const EvaluationInput input = paperInput(truth, 0.05, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const auto& slices = input.heldOut[axis];
    EXPECT_EQ(static_cast<std::int64_t>(slices.size()), truth.geometry.size[axis] / 20);
    EXPECT_EQ(std::set<std::int64_t>(slices.begin(), slices.end()).size(), slices.size());
    for (std::int64_t slice : slices)
      EXPECT_TRUE(slice >= 0 && slice < truth.geometry.size[axis]);
  }
  EXPECT_EQ(paperInput(truth, 0.05, 3).heldOut, input.heldOut);
  EXPECT_NE(paperInput(truth, 0.05, 4).heldOut, input.heldOut);
}

TEST(PaperProtocol, VoxelsHeldOutInAllPlanesNeverReachTheInput) {
  const Volume truth = randomVolume(grid(40, 42, 44), 0, 100);
  const EvaluationInput input = paperInput(truth, 0.1, 3);
  Volume wild = truth;
  std::size_t hidden = 0;
  for (std::int64_t k : input.heldOut[2])
    for (std::int64_t j : input.heldOut[1])
      for (std::int64_t i : input.heldOut[0]) {
        const auto p = static_cast<std::size_t>(i + 40 * (j + 42 * k));
        wild.voxels[p] = 1e6f;
        EXPECT_EQ(input.stacks[0].observed[p], 0);
        ++hidden;
      }
  EXPECT_EQ(hidden, 4u * 4 * 4);
  std::size_t unobserved = 0;
  for (std::uint8_t o : input.stacks[0].observed)
    unobserved += !o;
  EXPECT_EQ(unobserved, hidden);
  EXPECT_EQ(paperInput(wild, 0.1, 3).stacks[0].image.voxels, input.stacks[0].image.voxels);
}

TEST(PaperProtocol, PerPlaneHoldsOutEveryPlanesOwnSlicesFromItsStackAlone) {
  const Volume truth = randomVolume(grid(20, 22, 24, {1, 1, 1}, {3, 4, 5}, obliqueDirection(0.2)), 0, 100);
  const EvaluationInput input = paperInput(truth, 0.1, 3, true);
  EXPECT_EQ(input.heldOut, paperInput(truth, 0.1, 3).heldOut);
  ASSERT_EQ(input.stacks.size(), 3u);
  const int axes[3] = {2, 1, 0}; // axial, coronal, sagittal
  for (int s = 0; s < 3; ++s) {
    const Stack& stack = input.stacks[s];
    const GridGeometry& g = stack.image.geometry;
    const auto& heldOut = input.heldOut[axes[s]];
    ASSERT_EQ(g.size[2], truth.geometry.size[axes[s]]);
    std::size_t at = 0;
    for (std::int64_t k = 0; k < g.size[2]; ++k) {
      const bool hidden = std::count(heldOut.begin(), heldOut.end(), k) > 0;
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i, ++at) {
          ASSERT_EQ(stack.observed[at], hidden ? 0 : 1);
          const Vec3 x = g.indexToWorld()({double(i), double(j), double(k)});
          const Vec3 index = inverse(truth.geometry.indexToWorld())(x);
          ASSERT_EQ(stack.image.voxels[at],
                    hidden ? 0.f
                           : sampleLinear(
                                 truth, {std::round(index[0]), std::round(index[1]), std::round(index[2])}));
        }
    }
  }
}

TEST(PaperProtocol, ScoresAlphaBlendingAsRenderedInEveryPlane) {
  EvaluationOptions options;
  options.settings.blending = Blending::Alpha;
  options.settings.gaussians = 700;
  options.settings.iterations = 60;
  options.settings.threads = 2;
  options.keepVolumes = true;
  options.heldOutFraction = 0.15;
  const Volume truth = phantom(grid(26, 24, 22));
  const EvaluationReport report = evaluatePaper(truth, options);
  ASSERT_EQ(report.input->size(), 3u);
  ASSERT_TRUE(report.model);
  EXPECT_EQ(report.model->field.blending, Blending::Alpha);
  const MethodScore& gaussians = report.methods.front();
  ASSERT_EQ(gaussians.name, "gaussians");
  // Recomputes every plane's score from the field, rendered slice by slice in that plane.
  const EvaluationInput input = paperInput(truth, options.heldOutFraction, options.settings.seed, true);
  bool depends = false;
  for (const PlaneScore& plane : gaussians.perPlane) {
    const int axis = sliceAxis(truth.geometry, plane.plane);
    const Volume along = render(report.model->field, withSliceAxis(truth.geometry, axis));
    const Volume expected = withSliceAxis(truth, axis);
    double psnr = 0;
    for (std::int64_t slice : input.scored[axis])
      psnr += sliceQuality(along, expected, 2, slice, report.peak).psnr;
    psnr /= static_cast<double>(input.scored[axis].size());
    EXPECT_GT(psnr, 18) << planeName(plane.plane);
    EXPECT_NEAR(plane.psnr, psnr, 1e-9) << planeName(plane.plane);
    depends = depends || withSliceAxis(*gaussians.volume, axis).voxels != along.voxels;
  }
  EXPECT_TRUE(depends) << "the image depends on the slicing direction";
  options.keepVolumes = false;
  const EvaluationReport lean = evaluatePaper(truth, options);
  EXPECT_FALSE(lean.model);
  EXPECT_EQ(lean.methods.front().psnr, gaussians.psnr);
}

TEST(PaperProtocol, EmptySlicesAreNotScored) {
  Volume truth = randomVolume(grid(20, 20, 40), 0, 100);
  std::fill(truth.voxels.begin(), truth.voxels.begin() + 400 * 20, 0.0f); // the lower half is empty
  const EvaluationInput input = paperInput(truth, 0.2, 1);
  EXPECT_LT(input.scored[2].size(), input.heldOut[2].size());
  for (std::int64_t slice : input.scored[2])
    EXPECT_GE(slice, 20);
  EXPECT_EQ(input.scored[0], input.heldOut[0]);
}

TEST(PaperProtocol, ReportsPlanesAverageAndTheLeak) {
  EvaluationOptions options;
  options.gaussians = false;
  const EvaluationReport report = evaluatePaper(phantom(grid(40, 44, 48)), options);
  EXPECT_EQ(report.protocol, "paper");
  ASSERT_EQ(report.methods.size(), 3u);
  for (const MethodScore& method : report.methods) {
    ASSERT_EQ(method.perPlane.size(), 3u);
    double psnr = 0, ssim = 0;
    for (const PlaneScore& plane : method.perPlane) {
      psnr += plane.psnr / 3;
      ssim += plane.ssim / 3;
      EXPECT_EQ(plane.slices, 2);
    }
    EXPECT_NEAR(method.psnr, psnr, 1e-9);
    EXPECT_NEAR(method.ssim, ssim, 1e-9);
  }
  bool leak = false;
  for (const std::string& note : report.notes)
    leak = leak || note.find("leaks") != std::string::npos;
  EXPECT_TRUE(leak);
}

TEST(PaperProtocol, RefusesTooFewSlices) {
  EvaluationOptions options;
  options.gaussians = false;
  EXPECT_THROW(evaluatePaper(randomVolume(grid(40, 44, 4), 0, 1), options), Error);
  options.heldOutFraction = 0.7;
  EXPECT_THROW(evaluatePaper(randomVolume(grid(40, 44, 44), 0, 1), options), Error);
}
