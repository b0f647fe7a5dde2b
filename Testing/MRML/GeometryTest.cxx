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
  // A wrong axis is used as given, with an equal or worse result, but never fails.
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

  // An output that was under a transform also ends up in the world.
  volume->SetAndObserveTransformNodeID(outerNode->GetID());
  parameters->SetOutputVolumeNode(volume);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(error(volume), 6);

  // A region under a transform.
  auto* roi = addNode<vtkMRMLMarkupsROINode>();
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

// Like Crop Volume: the output's axes are the region's, unless the input's voxels are requested.
TEST_F(GeometryTest, TurnedRegion) {
  auto* parameters = addParameters(addVolume());
  auto* roi = addNode<vtkMRMLMarkupsROINode>();
  roi->SetSize(16, 12, 8);
  vtkNew<vtkTransform> turn;
  turn->RotateWXYZ(35, 1, 2, 3);
  roi->SetAndObserveTransformNodeID(addTransform(turn->GetMatrix())->GetID());
  parameters->SetROINode(roi);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  int size[3];
  volume->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 8); // 2 mm
  EXPECT_EQ(size[1], 6);
  EXPECT_EQ(size[2], 4);
  const auto matrix = matrixOf(volume);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_NEAR(std::abs(matrix->GetElement(row, column)),
                  std::abs(2 * turn->GetMatrix()->GetElement(row, column)), 1e-6);
  EXPECT_LT(error(volume, 0), 10);
  parameters->SetOutputGrid(vtkMRMLInnerGSParameterNode::InputGrid);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  logic->GetLastJob()->GetVolumeNode()->GetIJKToRASMatrix(matrix);
  EXPECT_NEAR(matrix->GetElement(0, 0), 2, 1e-6);
  EXPECT_NEAR(matrix->GetElement(0, 1), 0, 1e-6);
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

  // A volume made from a moved model is at the model's position.
  vtkNew<vtkTransform> back;
  back->DeepCopy(move);
  back->Inverse();
  node->SetMatrixTransformToParent(back->GetMatrix());
  model->SetAndObserveTransformNodeID(node->GetID());
  auto* volume = logic->Resample(model, 3);
  ASSERT_NE(volume, nullptr) << logic->GetLastError();
  EXPECT_LT(error(volume), 8);
}

// Hardening applies what the model can represent and leaves the rest as a parent: no value moves in the
// world.
TEST_F(GeometryTest, HardenedTransformsMoveNothing) {
  const int size[3] = {24, 22, 20};
  const double spacing[3] = {2, 2, 2}, origin[3] = {-23, -21, -19};
  vtkNew<vtkTransform> rigid, scaled, mirrored, sheared, turnedScale;
  rigid->Translate(4, -9, 7);
  rigid->RotateWXYZ(35, 1, 2, -1);
  scaled->Translate(5, 6, 7);
  scaled->Scale(1.5, 1.5, 1.5);
  mirrored->RotateZ(20);
  mirrored->Scale(-1, 1, 1);
  const double shear[16] = {1, 0.3, 0, 4, 0, 0.9, 0.2, -3, 0, 0, 1.2, 2, 0, 0, 0, 1};
  sheared->SetMatrix(shear);
  turnedScale->RotateY(30);
  turnedScale->Scale(1, 0.7, 2);
  turnedScale->RotateWXYZ(-40, 1, 1, 0); // oblique to the grid, so it shears it
  struct Case {
    const char* name;
    vtkTransform* transform;
    bool complete;
  };
  for (const bool slopes : {false, true}) {
    auto* parameters = addParameters(addVolume("Head", size, oblique(15, spacing, origin)));
    parameters->SetLinearIntensity(slopes);
    parameters->SetNumberOfIterations(20);
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    auto* fitted = logic->GetLastJob()->GetModelNode();
    for (const Case& c :
         {Case{"rigid", rigid, true}, Case{"scaled", scaled, true}, Case{"mirrored", mirrored, true},
          Case{"sheared", sheared, false}, Case{"turned scale", turnedScale, false}}) {
      SCOPED_TRACE(std::string(c.name) + (slopes ? ", slopes" : ""));
      auto* model = addNode<vtkMRMLInnerGSModelNode>(c.name);
      model->CopyContent(fitted);
      auto* node = addTransform(c.transform->GetMatrix(), c.name);
      model->SetAndObserveTransformNodeID(node->GetID());
      std::vector<std::array<double, 3>> at;
      std::vector<double> before;
      for (int n = 0; n < 60; ++n) { // some outside
        double x[3] = {25 * std::sin(1.0 * n), 24 * std::sin(1.7 * n + 1), 22 * std::sin(2.3 * n + 2)};
        c.transform->TransformPoint(x, x);
        at.push_back({x[0], x[1], x[2]});
        before.push_back(logic->GetValueAtRAS(model, x[0], x[1], x[2]));
      }
      ASSERT_TRUE(model->HardenTransform());
      auto* rest = vtkMRMLLinearTransformNode::SafeDownCast(model->GetParentTransformNode());
      EXPECT_EQ(rest == nullptr, c.complete);
      EXPECT_NE(rest, node);
      for (std::size_t n = 0; n < at.size(); ++n)
        EXPECT_NEAR(logic->GetValueAtRAS(model, at[n][0], at[n][1], at[n][2]), before[n], 0.1) << n;
      if (!rest) continue;
      // Without the rest, the model has moved: the rest is a shear, while the model was rotated and scaled.
      vtkNew<vtkMatrix4x4> matrix;
      rest->GetMatrixTransformToParent(matrix);
      EXPECT_NEAR(matrix->Determinant(), 1, 1e-6);
      EXPECT_FALSE(
          std::equal(matrix->GetData(), matrix->GetData() + 16, c.transform->GetMatrix()->GetData()));
      ASSERT_TRUE(model->HardenTransform()); // again: still nothing moves
      EXPECT_NEAR(logic->GetValueAtRAS(model, at[3][0], at[3][1], at[3][2]), before[3], 0.1);
      model->SetAndObserveTransformNodeID(nullptr); // removed by a person: it stays removed
      EXPECT_EQ(model->GetParentTransformNode(), nullptr);
    }
  }
  EXPECT_TRUE(errors.empty());
}

TEST_F(GeometryTest, HardeningInEveryBlending) {
  vtkNew<vtkTransform> transform;
  transform->Translate(1, 2, 3);
  transform->RotateX(70);
  transform->Scale(0.8, 1.3, -1.1);
  for (const int blending : {Parameters::Normalised, Parameters::Additive, Parameters::Alpha}) {
    SCOPED_TRACE(blending);
    auto* parameters = addParameters(addVolume());
    parameters->SetBlending(blending);
    parameters->SetNumberOfIterations(10);
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    auto* model = logic->GetLastJob()->GetModelNode();
    std::vector<double> before;
    for (int n = 0; n < 20; ++n)
      before.push_back(logic->GetValueAtRAS(model, n - 10.0, 8 - 0.7 * n, 0.9 * n - 7));
    vtkNew<vtkMatrix4x4> matrix;
    model->ApplyTransformMatrix(transform->GetMatrix()); // without a parent transform
    for (int n = 0; n < 20; ++n) {
      double x[3] = {n - 10.0, 8 - 0.7 * n, 0.9 * n - 7};
      transform->TransformPoint(x, x);
      EXPECT_NEAR(logic->GetValueAtRAS(model, x[0], x[1], x[2]), before[n], 0.2) << n;
    }
    // A shear cannot be applied, and there is no parent to leave it to.
    Observer quiet(model, {vtkCommand::ErrorEvent},
                   [&](unsigned long, void* text) { errors.emplace_back(static_cast<const char*>(text)); });
    vtkInnerGSModel* held = model->GetModel();
    matrix->SetElement(0, 1, 0.5);
    model->ApplyTransformMatrix(matrix);
    EXPECT_EQ(model->GetModel(), held);
    EXPECT_EQ(model->GetParentTransformNode(), nullptr);
  }
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_NE(errors[0].find("shears"), std::string::npos) << errors[0];
}

} // namespace
