#include "Core/Render/PlaneBudget.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

TEST(PlaneBudget, IsFullResolutionUntilMeasured) {
  EXPECT_EQ(PlaneBudget(16).pixelSize(1e9), 1);
  EXPECT_GT(PlaneBudget(40, 1, 1e-3).pixelSize(1e9), 1);
}

TEST(PlaneBudget, TakesPixelsAsLargeAsTheTimeNeeds) {
  PlaneBudget budget(16);
  budget.took(100, 1e6);
  EXPECT_DOUBLE_EQ(budget.pixelSize(1.6e5), 1);      // 16 ms
  EXPECT_DOUBLE_EQ(budget.pixelSize(16 * 1.6e5), 4); // a sixteenth of the pixels
  EXPECT_DOUBLE_EQ(budget.pixelSize(100), 1);
  budget.restart();
  EXPECT_EQ(budget.pixelSize(16 * 1.6e5), 1);
}

TEST(PlaneBudget, NeverGoesBelowTheFewestPixels) {
  PlaneBudget budget(40, 65536);
  budget.took(1e6, 1);
  EXPECT_DOUBLE_EQ(budget.pixelSize(4 * 65536), 2);
}

} // namespace
} // namespace innergs
