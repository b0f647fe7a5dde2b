#include "Evaluation/ExperimentDynamic.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Evaluation/JitteredPhantom.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace innergs;

namespace {

DynamicExperiment small() {
  JitteredPhantom phantom;
  phantom.geometry.size = {32, 32, 5};
  phantom.frames = 18;
  phantom.angleJitter = 0.1;
  phantom.shiftJitter = 0.05;
  phantom.swing = 20;
  phantom.period = 10;
  DynamicExperiment experiment;
  experiment.series = makeJitteredPhantom(phantom);
  experiment.name = experiment.series.name;
  return experiment;
}

} // namespace

TEST(ExperimentDynamic, GaussiansAreJudgedOnHeldOutFramesBesideEveryBaseline) {
  const DynamicExperimentResult result = runDynamic(small());
  const auto psnr = [&](const std::string& method) {
    for (const auto& row : result.methods.rows)
      if (row[0].starts_with(method)) return leadingNumber(row[2]).value();
    ADD_FAILURE() << method;
    return 0.0;
  };
  for (const char* method : {"nearest frame", "cubic in time", "temporal mean", "voxel smoothing spline",
                             "motion-compensated", "noise ceiling", "Gaussians, intensity"})
    EXPECT_GT(psnr(method), 10) << method;
  EXPECT_GT(psnr("Gaussians, motion (chosen)"), psnr("linear in time") + 1);
  EXPECT_GT(psnr("linear in time"), psnr("previous frame"));
  EXPECT_GT(psnr("Gaussians, network"), psnr("previous frame"));
  EXPECT_EQ(result.frames.rows.size(), 2u * 10); // frames 8 and 16, ten methods
  for (const auto* table : {&result.methods, &result.frames})
    for (const auto& row : table->rows)
      EXPECT_NE(row.back().find("held-out frame"), std::string::npos);
}

TEST(ExperimentDynamic, RefusesWhatItCannotHoldOut) {
  DynamicExperiment experiment = small();
  experiment.series = framesOf(experiment.series, {0, 1, 2, 3});
  EXPECT_THROW(runDynamic(experiment), Error);
  experiment = small();
  std::stop_source stop;
  stop.request_stop();
  experiment.stop = stop.get_token();
  EXPECT_THROW(runDynamic(experiment), Error);
}

TEST(JitteredPhantom, IsTheSameForASeedAndJitters) {
  JitteredPhantom phantom;
  phantom.geometry.size = {16, 16, 4};
  phantom.frames = 3;
  const TimeSeries a = makeJitteredPhantom(phantom), b = makeJitteredPhantom(phantom);
  EXPECT_EQ(a.frames, b.frames);
  phantom.seed = 2;
  EXPECT_NE(makeJitteredPhantom(phantom).frames, a.frames);
}
