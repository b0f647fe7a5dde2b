#include "MrmlFixture.h"

#include <vtkMRMLMarkupsROINode.h>
#include <vtkTransform.h>

namespace {

using GeometryTest = MrmlFixture;
using Parameters = vtkMRMLInnerGSParameterNode;

TEST_F(GeometryTest, ObliqueAndLeftHanded) {
  const int size[3] = {24, 22, 12};
  for (const bool mirrored : {false, true}) {
    const double spacing[3] = {mirrored ? -2.0 : 2.0, 2, 3.5},
                 origin[3] = {mirrored ? 24.0 : -24.0, -20, -18};
    auto matrix = oblique(25, spacing, origin);
    ASSERT_EQ(matrix->Determinant() < 0, mirrored);
    auto* input = addVolume(mirrored ? "Left" : "Right", size, matrix);
    auto* parameters = addParameters(input);
    for (const int grid : {Parameters::AutomaticGrid, Parameters::InputGrid}) {
      parameters->SetOutputGrid(grid);
      ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
      EXPECT_LT(error(logic->GetLastJob()->GetVolumeNode()), 8);
    }
    double centre[4] = {11.3, 10.2, 6.1, 1};
    matrix->MultiplyPoint(centre, centre);
    EXPECT_NEAR(logic->GetValueAtRAS(logic->GetLastJob()->GetModelNode(), centre[0], centre[1], centre[2]),
                truth(centre[0], centre[1], centre[2]), 10);
  }
}

TEST_F(GeometryTest, SliceAxisIsFound) {
  const int size[3] = {8, 30, 28}; // thick sagittal slices: I counts them
  const double spacing[3] = {6, 1.5, 1.5}, origin[3] = {-20, -22, -20};
  auto* parameters = addParameters(addVolume("Sagittal", size, oblique(10, spacing, origin)));
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(error(logic->GetLastJob()->GetVolumeNode(), 4), 25);
  // A wrong axis is obeyed, and worse or equal, never a failure.
  parameters->SetInputSliceAxis(parameters->GetInputVolumeNode(), 2);
  EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
}

TEST_F(GeometryTest, ParentTransforms) {
  vtkNew<vtkTransform> outer, inner;
  outer->Translate(5, -7, 11);
  outer->RotateZ(30);
  inner->RotateX(-20);
  inner->Translate(1, 2, 3);
  auto* outerNode = addTransform(outer->GetMatrix(), "Outer");
  auto* innerNode = addTransform(inner->GetMatrix(), "Inner");
  innerNode->SetAndObserveTransformNodeID(outerNode->GetID());
  vtkNew<vtkMatrix4x4> toWorld;
  innerNode->GetMatrixTransformToWorld(toWorld);

  const int size[3] = {24, 22, 20};
  const double spacing[3] = {2, 2, 2}, origin[3] = {-23, -21, -19};
  auto matrix = oblique(15, spacing, origin);
  auto* input = addVolume("Moved", size, matrix, toWorld);
  input->SetAndObserveTransformNodeID(innerNode->GetID());
  auto* parameters = addParameters(input);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  EXPECT_EQ(volume->GetParentTransformNode(), nullptr);
  EXPECT_LT(error(volume), 6);

  // An output that was under a transform ends up in the world as well.
  volume->SetAndObserveTransformNodeID(outerNode->GetID());
  parameters->SetOutputVolumeNode(volume);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(error(volume), 6);

  // A region under a transform.
  auto* roi = vtkMRMLMarkupsROINode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLMarkupsROINode"));
  roi->SetCenter(0, 0, 0);
  roi->SetSize(16, 14, 12);
  roi->SetAndObserveTransformNodeID(innerNode->GetID());
  parameters->SetROINode(roi);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(error(volume, 0), 8);
  int dimensions[3];
  volume->GetImageData()->GetDimensions(dimensions);
  EXPECT_EQ(dimensions[0] * dimensions[1] * dimensions[2], 8 * 7 * 6);
}

TEST_F(GeometryTest, TransformsOfTheModel) {
  auto* input = addVolume();
  ASSERT_TRUE(logic->Reconstruct(addParameters(input)));
  auto* model = logic->GetLastJob()->GetModelNode();
  const double before = logic->GetValueAtRAS(model, 3, 4, 5);
  vtkNew<vtkTransform> move;
  move->Translate(10, 20, 30);
  move->RotateZ(90);
  auto* node = addTransform(move->GetMatrix());
  model->SetAndObserveTransformNodeID(node->GetID());
  double at[3] = {3, 4, 5};
  move->TransformPoint(at, at);
  EXPECT_NEAR(logic->GetValueAtRAS(model, at[0], at[1], at[2]), before, 1e-3);
  double bounds[6], hardened[6];
  model->GetRASBounds(bounds);
  ASSERT_TRUE(model->HardenTransform());
  EXPECT_EQ(model->GetParentTransformNode(), nullptr);
  model->GetRASBounds(hardened);
  for (int n = 0; n < 6; ++n)
    EXPECT_NEAR(bounds[n], hardened[n], 1e-3);
  EXPECT_NEAR(logic->GetValueAtRAS(model, at[0], at[1], at[2]), before, 0.05);

  // A volume made from a moved model is where the model is.
  vtkNew<vtkTransform> back;
  back->DeepCopy(move);
  back->Inverse();
  node->SetMatrixTransformToParent(back->GetMatrix());
  model->SetAndObserveTransformNodeID(node->GetID());
  auto* volume = logic->Resample(model, 3);
  ASSERT_NE(volume, nullptr) << logic->GetLastError();
  EXPECT_LT(error(volume), 8);
}

} // namespace
