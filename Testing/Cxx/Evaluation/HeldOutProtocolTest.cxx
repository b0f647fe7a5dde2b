#include "Evaluation/HeldOutProtocol.h"
#include "Core/Base/Error.h"
#include "Core/Base/Quantities.h"
#include "Core/Image/BodyMask.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/Baselines.h"

#include "../Core/TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

EvaluationOptions baselinesOnly() {
  EvaluationOptions options;
  options.gaussians = false;
  return options;
}

std::vector<std::string> names(const EvaluationReport& report) {
  std::vector<std::string> result;
  for (const MethodScore& method : report.methods)
    result.push_back(method.name);
  return result;
}

const MethodScore& method(const EvaluationReport& report, const std::string& name) {
  return *std::find_if(report.methods.begin(), report.methods.end(),
                       [&](const MethodScore& m) { return m.name == name; });
}

} // namespace

TEST(Protocols, SliceAxesFollowTheAnatomy) {
  Mat3 d; // I runs foot to head, J right to left, K front to back
  d.m = {{{0, 1, 0}, {0, 0, 1}, {-1, 0, 0}}};
  const GridGeometry g = grid(4, 5, 6, {1, 1, 1}, {0, 0, 0}, d);
  EXPECT_EQ(sliceAxis(g, Plane::Axial), 0);
  EXPECT_EQ(sliceAxis(g, Plane::Coronal), 2);
  EXPECT_EQ(sliceAxis(g, Plane::Sagittal), 1);
  for (double angle = 0; angle < 3.2; angle += 0.1) { // always three different axes
    const GridGeometry turned = grid(4, 5, 6, {1, 1, 1}, {0, 0, 0}, obliqueDirection(angle, true));
    const int a = sliceAxis(turned, Plane::Axial), c = sliceAxis(turned, Plane::Coronal),
              s = sliceAxis(turned, Plane::Sagittal);
    EXPECT_EQ((1 << a) | (1 << c) | (1 << s), 7) << angle;
  }
}

TEST(HeldOutProtocol, HeldOutVoxelsNeverReachTheInput) {
  const Volume truth = randomVolume(grid(12, 14, 18), 0, 100);
  for (int k = 2; k <= 6; ++k) {
    HeldOutCase c;
    c.factor = k;
    const EvaluationInput input = heldOutInput(truth, c);
    Volume wild = truth;
    std::vector<std::uint8_t> heldOut(static_cast<std::size_t>(truth.geometry.size[2]), 0);
    for (std::int64_t slice : input.testSlices)
      heldOut[slice] = 1;
    for (std::size_t p = 0; p < wild.voxels.size(); ++p)
      if (heldOut[p / (12 * 14)]) wild.voxels[p] = 1e6f * float(p % 13) - 4e6f;
    const EvaluationInput other = heldOutInput(wild, c);
    ASSERT_EQ(input.stacks.size(), 1u);
    EXPECT_EQ(input.stacks[0].image.voxels, other.stacks[0].image.voxels);
    EXPECT_EQ(input.stacks[0].image.geometry, other.stacks[0].image.geometry);
    EXPECT_EQ(input.testSlices, other.testSlices);
    // Every test slice lies between kept ones, and none is kept.
    const std::int64_t last = (18 - 1) / k * k;
    for (std::int64_t slice : input.testSlices) {
      EXPECT_NE(slice % k, 0);
      EXPECT_LT(slice, last);
    }
    EXPECT_EQ(static_cast<std::int64_t>(input.testSlices.size()), last - last / k);
  }
}

TEST(HeldOutProtocol, ThickInputsAreTheSimulatedStacksOfTheCutTruth) {
  const Volume truth = randomVolume(grid(13, 14, 18), 0, 100);
  HeldOutCase c{HeldOutCase::Kind::Orthogonal, 4, 3, 0};
  const EvaluationInput input = heldOutInput(truth, c);
  EXPECT_EQ(input.truth.geometry.size, (std::array<std::int64_t, 3>{12, 12, 16}));
  ASSERT_EQ(input.stacks.size(), 3u);
  const int axes[3] = {2, 1, 0}; // axial, coronal, sagittal
  for (int s = 0; s < 3; ++s)
    EXPECT_EQ(input.stacks[s].image.voxels, simulateThickStack(input.truth, axes[s], 4).image.voxels);
  c.kind = HeldOutCase::Kind::Thick;
  EXPECT_EQ(heldOutInput(truth, c).truth.geometry.size, (std::array<std::int64_t, 3>{13, 14, 16}));
}

TEST(HeldOutProtocol, AxialSlicesAreFoundInAnyGrid) {
  const Volume k = phantom(grid(16, 18, 20));
  // The same patient, stored with the axial direction along I.
  const Volume i = withSliceAxis(k, 0);
  ASSERT_EQ(sliceAxis(i.geometry, Plane::Axial), 1);
  HeldOutCase c;
  c.factor = 3;
  const auto a = evaluateHeldOut(k, c, baselinesOnly()), b = evaluateHeldOut(i, c, baselinesOnly());
  EXPECT_EQ(a.voxels, b.voxels);
  EXPECT_NEAR(method(a, "cubic").psnr, method(b, "cubic").psnr, 1e-3);
}

TEST(HeldOutProtocol, SlicesCanBeThoseThatTheScanHas) {
  const Volume axial = randomVolume(grid(12, 14, 18), 0, 100);
  HeldOutCase c;
  c.factor = 3;
  c.axis = 0;
  const EvaluationInput input = heldOutInput(axial, c);
  EXPECT_EQ(input.truth.geometry.size[2], (12 - 1) / 3 * 3 + 1);
  EXPECT_EQ(input.stacks[0].image.voxels, keepEvery(withSliceAxis(axial, 0), 2, 3).image.voxels);
  EXPECT_EQ(input.stacks[0].name, "sagittal");
  const EvaluationReport report = evaluateHeldOut(phantom(grid(24, 26, 29)), c, baselinesOnly());
  EXPECT_NE(report.samples.find("the sagittal slices between the kept ones"), std::string::npos)
      << report.samples;
  GridGeometry sagittal = grid(17, 40, 40, {5, 1, 1});
  EXPECT_EQ(usualGap(sagittal), 4);
  EXPECT_EQ(usualGap(sagittal, 0), 2);
  const ReconstructionInput kept = keptOutline(sagittal, 0, 0);
  EXPECT_EQ(kept.stacks[0].image.geometry.size[2], 9);
  EXPECT_DOUBLE_EQ(kept.stacks[0].image.geometry.spacing[2], 10);
  sagittal = grid(9, 40, 40, {1, 1, 1});
  EXPECT_EQ(usualGap(sagittal, 0), 2) << "so few slices";
  c.axis = 3;
  EXPECT_THROW(heldOutInput(axial, c), Error);
  EXPECT_THROW(heldOutInput(axial, {HeldOutCase::Kind::Orthogonal, 4, 2, 0, 0}), Error);
}

TEST(HeldOutProtocol, WithAMaskFitsAndScoresInsideIt) {
  const Volume truth = phantom(grid(24, 26, 29));
  const GridGeometry half = cropped(truth.geometry, {0, 0, 0}, {12, 26, 29});
  auto options = baselinesOnly();
  options.mask = Mask{half, std::vector<std::uint8_t>(static_cast<std::size_t>(half.voxelCount()), 1)};
  HeldOutCase c;
  const EvaluationReport report = evaluateHeldOut(truth, c, options);
  const auto tested = static_cast<std::int64_t>(heldOutInput(truth, c).testSlices.size());
  EXPECT_EQ(report.voxels, 12 * 26 * tested);
  EXPECT_NE(report.samples.find("inside the mask"), std::string::npos) << report.samples;
  // Nothing outside is fitted either.
  options.gaussians = true;
  options.settings.preset = Preset::Fast;
  options.settings.gaussians = 500;
  Volume other = truth;
  for (std::size_t p = 0; p < other.voxels.size(); ++p)
    if (p % 24 >= 12) other.voxels[p] *= 0.5f;
  const auto error = [&](const Volume& volume) { // dB, for any peak
    const EvaluationReport r = evaluateHeldOut(volume, c, options);
    return method(r, "gaussians").psnr - 20 * std::log10(r.peak);
  };
  EXPECT_NEAR(error(truth), error(other), 1e-6);
  options.mask->geometry.origin[0] += 1000;
  EXPECT_THROW(evaluateHeldOut(truth, c, options), Error);
}

TEST(HeldOutProtocol, TheUsualGapFollowsTheSlicesDistance) {
  Volume truth = phantom(grid(24, 26, 29));
  truth.geometry.spacing = {1, 1, 1};
  EXPECT_EQ(usualGap(truth.geometry), 4);
  truth.geometry.spacing[sliceAxis(truth.geometry, Plane::Axial)] = 5;
  EXPECT_EQ(usualGap(truth.geometry), 2);
  const EvaluationReport report = evaluateHeldOut(truth, {HeldOutCase::Kind::KeepEvery, 0}, baselinesOnly());
  EXPECT_EQ(report.caseName, "keep-every-2");
  EXPECT_NE(report.samples.find("every 2nd, 10 mm apart"), std::string::npos) << report.samples;
  const ReconstructionInput kept = keptOutline(truth.geometry, 0);
  const EvaluationInput input = heldOutInput(truth, {HeldOutCase::Kind::KeepEvery, 0});
  EXPECT_EQ(kept.stacks[0].image.geometry.size, input.stacks[0].image.geometry.size);
  EXPECT_EQ(kept.stacks[0].image.geometry.spacing, input.stacks[0].image.geometry.spacing);
}

TEST(HeldOutProtocol, ScoresAreThoseOfTheMethodsOnTheNamedSamples) {
  const Volume truth = phantom(grid(24, 26, 29));
  HeldOutCase c; // keep every 4th
  auto options = baselinesOnly();
  options.keepVolumes = true;
  const EvaluationReport report = evaluateHeldOut(truth, c, options);
  EXPECT_EQ(report.protocol, "held-out");
  EXPECT_EQ(report.caseName, "keep-every-4");
  EXPECT_EQ(names(report), (std::vector<std::string>{"linear", "cubic", "lanczos"}));
  const auto [low, high] = std::minmax_element(truth.voxels.begin(), truth.voxels.end());
  EXPECT_FLOAT_EQ(float(report.peak), *high - *low);

  const Volume linear = averageUpsampled(std::vector{keepEvery(*report.truth, 2, 4)}, report.truth->geometry,
                                         Interpolation::Linear);
  const auto mask = bodyMask(*report.truth);
  double squares = 0;
  std::int64_t count = 0;
  for (std::size_t p = 0; p < mask.size(); ++p)
    if (mask[p] && p / (24 * 26) % 4 != 0) {
      squares += std::pow(double(linear.voxels[p]) - report.truth->voxels[p], 2);
      ++count;
    }
  EXPECT_EQ(report.voxels, count);
  EXPECT_NEAR(method(report, "linear").psnr,
              10 * std::log10(report.peak * report.peak * double(count) / squares), 1e-4);
  EXPECT_NE(report.samples.find(countText(count) + " voxels"), std::string::npos);
}

TEST(HeldOutProtocol, OrthogonalStacksBeatOneAndBackProjectionBeatsTheAverage) {
  const Volume truth = phantom(grid(32, 32, 32));
  HeldOutCase c{HeldOutCase::Kind::Orthogonal, 4, 2, 0};
  const EvaluationReport report = evaluateHeldOut(truth, c, baselinesOnly());
  EXPECT_EQ(report.caseName, "orthogonal-2-thick-4");
  EXPECT_EQ(names(report),
            (std::vector<std::string>{"linear", "cubic", "lanczos", "average", "backprojection"}));
  EXPECT_GT(method(report, "average").psnr, method(report, "cubic").psnr);
  EXPECT_GT(method(report, "backprojection").psnr, method(report, "average").psnr + 1);
}

TEST(HeldOutProtocol, GaussiansAreScoredBesideTheBaselines) {
  EvaluationOptions options;
  options.settings.preset = Preset::Fast;
  options.settings.gaussians = 2000;
  std::vector<std::string> announced;
  options.onMethod = [&](const std::string& name) { announced.push_back(name); };
  HeldOutCase c;
  c.factor = 2;
  const EvaluationReport report = evaluateHeldOut(phantom(grid(24, 24, 25)), c, options);
  EXPECT_EQ(names(report), announced);
  ASSERT_EQ(report.methods.front().name, "gaussians");
  EXPECT_GT(report.methods.front().psnr, 15);
  EXPECT_GT(report.methods.front().seconds, 0);
}

TEST(HeldOutProtocol, RefusesWhatMakesNoSense) {
  const Volume truth = randomVolume(grid(12, 14, 18), 0, 100);
  EXPECT_THROW(evaluateHeldOut(truth, {HeldOutCase::Kind::KeepEvery, 1, 2, 0}, baselinesOnly()), Error);
  EXPECT_THROW(evaluateHeldOut(truth, {HeldOutCase::Kind::Thick, 12, 2, 0}, baselinesOnly()), Error);
  EXPECT_THROW(evaluateHeldOut(truth, {HeldOutCase::Kind::Orthogonal, 4, 4, 0}, baselinesOnly()), Error);
  EXPECT_THROW(evaluateHeldOut(truth, {HeldOutCase::Kind::Thick, 4, 2, -1}, baselinesOnly()), Error);
  const Volume flat = volumeOf(grid(12, 14, 18), [](auto, auto, auto) { return 5; });
  EXPECT_THROW(evaluateHeldOut(flat, {}, baselinesOnly()), Error);
  auto stopped = baselinesOnly();
  std::stop_source source;
  source.request_stop();
  stopped.stop = source.get_token();
  EXPECT_THROW(evaluateHeldOut(truth, {}, stopped), Error);
}
