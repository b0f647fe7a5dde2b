#include "SegmentationFixture.h"

namespace {

using EstimateMaskTest = SegmentationFixture;

// Counts the mask's support, whichever node holds it, and again after an edit.
TEST_F(EstimateMaskTest, CountsWhatTheMaskHolds) {
  auto* parameters = addParameters(input);
  parameters->SetDevice("cpu");
  parameters->SetNumberOfIterations(200);
  parameters->SetSetting("consistency", "false"); // in a scan this small the residual grid needs the most
  const vtkTypeInt64 whole = logic->EstimateMemory(parameters);
  const double seconds = logic->EstimateSeconds(parameters);
  ASSERT_GT(whole, 0);
  ASSERT_GT(seconds, 0);

  auto* mask = addVolume("Mask");
  vtkImageData* image = mask->GetImageData();
  vtkDataArray* voxels = image->GetPointData()->GetScalars();
  voxels->Fill(0);
  int size[3];
  image->GetDimensions(size);
  for (int k = 6; k < 12; ++k)
    for (int j = 6; j < 12; ++j)
      for (int i = 6; i < 12; ++i)
        image->SetScalarComponentFromDouble(i, j, k, 0, 1);
  parameters->SetMaskNode(mask);
  const vtkTypeInt64 small = logic->EstimateMemory(parameters);
  EXPECT_LT(small, whole);
  EXPECT_LT(logic->EstimateSeconds(parameters), seconds);

  voxels->Fill(1);
  image->Modified();
  const vtkTypeInt64 full = logic->EstimateMemory(parameters);
  EXPECT_GT(full, small);

  // The same voxels as a segment.
  const auto matrix = matrixOf(mask);
  const int extent[6] = {0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1};
  const auto labels = balls(matrix, extent, VTK_UNSIGNED_CHAR, {});
  for (int k = 6; k < 12; ++k)
    for (int j = 6; j < 12; ++j)
      for (int i = 6; i < 12; ++i)
        labels->SetScalarComponentFromDouble(i, j, k, 0, 1);
  addSegment("Cube", labels);
  parameters->SetMaskNode(node);
  EXPECT_NEAR(double(logic->EstimateMemory(parameters)), double(small), 0.02 * double(small));
  labels->GetPointData()->GetScalars()->Fill(1);
  labels->Modified();
  EXPECT_NEAR(double(logic->EstimateMemory(parameters)), double(full), 0.02 * double(full));

  // Surfaces are counted as all there is, without their slow conversion.
  segments->RemoveAllSegments();
  addSurface("Ball", 0, 12);
  EXPECT_EQ(logic->EstimateMemory(parameters), whole);
  EXPECT_TRUE(WatchedRule::threads.empty());
}

} // namespace
