#include "../Cxx/VTK/Allocations.h"
#include "MrmlFixture.h"

#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLTableNode.h>

namespace {

using CopyTest = MrmlFixture;
using innergs::testing::largeAllocations;
using innergs::testing::resetLargeAllocations;

/// Number of voxels (floats) that StartReconstruction() copied on this thread.
double copied(vtkSlicerInnerGSLogic* logic, vtkMRMLInnerGSParameterNode* parameters) {
  resetLargeAllocations();
  EXPECT_NE(logic->StartReconstruction(parameters), nullptr) << logic->GetLastError();
  const double bytes = static_cast<double>(largeAllocations());
  logic->Cancel();
  return bytes / sizeof(float);
}

TEST_F(CopyTest, VoxelsAreCopiedOnceWithQualitySliceAxisAndRegion) {
  const int size[3] = {60, 64, 56};
  const double voxels = 60 * 64 * 56;
  vtkNew<vtkMatrix4x4> matrix; // 1 mm, the first voxel in the origin
  auto* input = addVolume("Large", size, matrix);
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(100000);
  EXPECT_EQ(copied(logic, parameters), voxels);
  parameters->EvaluateQualityOn();
  EXPECT_EQ(copied(logic, parameters), voxels);
  parameters->SetInputSliceAxis(input, 0);
  EXPECT_EQ(copied(logic, parameters), voxels);
  auto* roi = addNode<vtkMRMLMarkupsROINode>();
  roi->SetCenter(29.5, 31.5, 27.5);
  roi->SetSize(40, 32, 24);
  parameters->SetROINode(roi);
  EXPECT_EQ(copied(logic, parameters), 44 * 36 * 28); // a margin of two slices around it
}

TEST_F(CopyTest, QualityIsJudgedInTheRegion) {
  auto* parameters = addParameters(addVolume());
  auto* roi = addNode<vtkMRMLMarkupsROINode>();
  roi->SetCenter(1, 1, 1);
  roi->SetSize(28, 28, 28);
  parameters->SetNumberOfIterations(10);
  parameters->EvaluateQualityOn();
  parameters->SetQualityGap(2);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  const auto samples = [&] {
    auto* table = logic->GetLastJob()->GetTableNode();
    std::string text = table ? table->GetAttribute("InnerGS.Samples") : "-1"; // "1,234 voxels: …"
    std::erase(text, ',');
    return std::atol(text.c_str());
  };
  const long whole = samples();
  parameters->SetROINode(roi);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_GT(samples(), 1000);
  EXPECT_LT(samples(), whole);
}

} // namespace
