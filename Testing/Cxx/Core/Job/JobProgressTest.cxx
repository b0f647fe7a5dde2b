#include "Core/Job/JobProgress.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

TEST(JobProgress, RemainingTimeFollowsThePaceSinceItChanged) {
  EXPECT_EQ(remainingSeconds({}, {0.01, 5}), 0) << "too early";
  EXPECT_DOUBLE_EQ(remainingSeconds({}, {0.2, 40}), 160);
  const JobTime searched{0.2, 40};
  EXPECT_EQ(remainingSeconds(searched, {0.21, 42}), 0) << "too early again";
  EXPECT_DOUBLE_EQ(remainingSeconds(searched, {0.6, 60}), 20) << "five times faster since";
  EXPECT_DOUBLE_EQ(remainingSeconds(searched, {1, 80}), 0);
}

TEST(JobProgress, NeverFallsBack) {
  Progress last;
  JobProgress progress([&](const Progress& p) { last = p; });
  progress.report(Phase::Aligning, 0.3);
  progress.changePace();
  progress.report(Phase::Fitting, 0.2);
  EXPECT_EQ(last.fraction, 0.3);
  EXPECT_GE(last.remaining, 0);
  progress.report(Phase::Done, 1);
  EXPECT_EQ(last.remaining, 0);
}

} // namespace
} // namespace innergs
