#include "Evaluation/ScansProtocol.h"
#include "Evaluation/Report.h"
#include "Evaluation/SimulatedStacks.h"

#include "../Core/Alignment/HeadPhantom.h"
#include "../Core/ThrownError.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

std::vector<Stack> movingScans(std::int64_t width) {
  ThreadPool pool(2);
  StacksCase c;
  c.thickness = 4;
  c.noise = 1;
  c.motion = c.turn = 2;
  return simulateStacks(testing::headPhantom(width), c, pool).stacks;
}

EvaluationOptions quick() {
  EvaluationOptions options;
  options.settings.preset = Preset::Fast;
  options.settings.device = "cpu";
  options.heldOutFraction = 0.2;
  return options;
}

TEST(ScansProtocol, PredictsHeldOutSlicesBetterThanTheAverage) {
  const std::vector<Stack> scans = movingScans(48);
  const EvaluationReport report = evaluateScans(scans, {}, quick());
  ASSERT_EQ(report.methods.size(), 3u);
  for (std::size_t m : {1, 2}) {
    EXPECT_GT(report.methods[0].psnr, report.methods[m].psnr + 2) << report.methods[m].name;
    EXPECT_GT(*report.methods[0].ncc, *report.methods[m].ncc + 0.01) << report.methods[m].name;
    EXPECT_GT(*report.methods[m].ncc, 0.5) << "registered as well";
  }
  EXPECT_LT(*report.methods[0].ncc, 1);
  const std::vector<EvaluationReport> reports{report};
  EXPECT_NE(textReport(reports).find("NCC"), std::string::npos);
  EXPECT_NE(jsonReport(reports).find("\"ncc\""), std::string::npos);
}

TEST(ScansProtocol, ScoresHeldOutSlicesInsideTheMask) {
  const std::vector<Stack> scans = movingScans(40);
  const GridGeometry& g = scans[0].image.geometry;
  Mask lower{g, std::vector<std::uint8_t>(scans[0].image.voxels.size(), 1)};
  const std::int64_t plane = g.size[0] * g.size[1];
  std::fill_n(lower.voxels.begin() + g.size[2] / 2 * plane, (g.size[2] - g.size[2] / 2) * plane,
              std::uint8_t{0});
  EvaluationOptions options = quick();
  options.settings.iterations = 4;
  const EvaluationReport report = evaluateScans(scans, {lower}, options);
  std::int64_t inside = 0; // of all scans' held-out slices, every fifth from the third on
  for (const Stack& scan : scans) {
    const auto mask = resampleMask(lower, scan.image.geometry);
    const std::int64_t slice = scan.image.geometry.size[0] * scan.image.geometry.size[1];
    for (std::int64_t k = 2; k + 1 < scan.image.geometry.size[2]; k += 5)
      inside += std::count(mask.begin() + k * slice, mask.begin() + (k + 1) * slice, 1);
  }
  EXPECT_LE(report.voxels, inside);
  EXPECT_GT(report.voxels, inside * 6 / 10);
}

TEST(ScansProtocol, RefusesWhatCannotBe) {
  std::vector<Stack> scans = movingScans(24);
  EvaluationOptions most = quick();
  most.heldOutFraction = 0.5;
  EXPECT_EQ(test::codeOf([&] { evaluateScans(scans, {}, most); }), ErrorCode::InvalidArgument);
  scans.resize(1);
  EXPECT_EQ(test::codeOf([&] { evaluateScans(scans, {}, quick()); }), ErrorCode::InvalidArgument);
}

} // namespace
} // namespace innergs
