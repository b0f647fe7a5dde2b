#include "QueryFixture.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLSliceNode.h>

#include <vtkFloatArray.h>
#include <vtkGeneralTransform.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkThinPlateSplineTransform.h>
#include <vtkTransform.h>

#include <utility>

namespace {

TEST_F(QueryTest, Points) {
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(1, 2, 3);
  points->InsertNextPoint(-8, 7, -6);
  vtkNew<vtkFloatArray> values;
  ASSERT_TRUE(logic->GetValuesAtRAS(model, points, values));
  ASSERT_EQ(values->GetNumberOfTuples(), 2);
  EXPECT_NEAR(values->GetValue(0), truth(1, 2, 3), 8);
  EXPECT_NEAR(values->GetValue(1), truth(-8, 7, -6), 8);
  EXPECT_FLOAT_EQ(static_cast<float>(logic->GetValueAtRAS(model, 1, 2, 3)), values->GetValue(0));
}

TEST_F(QueryTest, ObliquePlane) {
  vtkNew<vtkTransform> pose;
  pose->Translate(1, -2, 3);
  pose->RotateWXYZ(35, 1, 1, 0);
  auto* plane = logic->QueryPlane(model, pose->GetMatrix(), 21, 15, 0.8);
  ASSERT_NE(plane, nullptr) << logic->GetLastError();
  int size[3];
  plane->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 21);
  EXPECT_EQ(size[1], 15);
  EXPECT_EQ(size[2], 1);
  EXPECT_LT(error(plane, 0), 6);
  const auto matrix = matrixOf(plane);
  double middle[4] = {10, 7, 0, 1};
  matrix->MultiplyPoint(middle, middle);
  EXPECT_NEAR(middle[0], 1, 1e-9);
  EXPECT_NEAR(middle[1], -2, 1e-9);
  EXPECT_NEAR(middle[2], 3, 1e-9);
  EXPECT_EQ(logic->QueryPlane(model, pose->GetMatrix(), 8, 8, 1, plane), plane); // in place
  plane->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 8);
}

TEST_F(QueryTest, Resampled) {
  auto* fine = logic->Resample(model, 1);
  ASSERT_NE(fine, nullptr);
  int size[3];
  fine->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 48);
  EXPECT_LT(error(fine, 4), 6);
  const int small[3] = {7, 6, 5};
  const double spacing[3] = {-2, 2, 2}, origin[3] = {6, -5, -4}; // left-handed
  auto* reference = addVolume("Reference", small, oblique(40, spacing, origin));
  auto* like = logic->ResampleLike(model, reference);
  ASSERT_NE(like, nullptr);
  EXPECT_LT(error(like, 0), 6);
}

TEST_F(QueryTest, NewNodeRemovedByAnObserver) {
  Observer watch(scene, {vtkMRMLScene::NodeAddedEvent}, [&](unsigned long, void* data) {
    auto* node = static_cast<vtkMRMLNode*>(data);
    if (node->IsA("vtkMRMLScalarVolumeNode") || node->IsA("vtkMRMLModelNode")) scene->RemoveNode(node);
  });
  vtkNew<vtkMRMLSliceNode> slice;
  slice->SetDimensions(20, 20, 1);
  EXPECT_EQ(logic->Resample(model, 2), nullptr);
  EXPECT_EQ(logic->CreateGaussianModel(model, 5), nullptr);
  EXPECT_EQ(logic->FollowSlice(model, slice), nullptr);
}

// The scene held the only reference to the model.
TEST_F(QueryTest, ModelRemovedByAnObserverOfTheNewNode) {
  const vtkSmartPointer<vtkInnerGSModel> content = model->GetModel();
  auto* reference = addVolume("Reference");
  auto* slice = addNode<vtkMRMLSliceNode>("Red");
  slice->SetLayoutName("Red");
  vtkNew<vtkMatrix4x4> pose;
  for (int which = 0; which < 5; ++which) {
    SCOPED_TRACE(which);
    auto* shown = addNode<vtkMRMLInnerGSModelNode>();
    shown->SetModel(content);
    Observer watch(scene, {vtkMRMLScene::NodeAddedEvent}, [&](unsigned long, void* data) {
      auto* node = static_cast<vtkMRMLNode*>(data);
      if (shown && (node->IsA("vtkMRMLScalarVolumeNode") || node->IsA("vtkMRMLModelNode")))
        scene->RemoveNode(std::exchange(shown, nullptr));
    });
    vtkMRMLNode* made = which == 0   ? logic->QueryPlane(shown, pose, 8, 8, 1)
                        : which == 1 ? logic->Resample(shown, 4)
                        : which == 2 ? logic->ResampleLike(shown, reference)
                        : which == 3 ? logic->FollowSlice(shown, slice)
                                     : static_cast<vtkMRMLNode*>(logic->CreateGaussianModel(shown, 5));
    EXPECT_EQ(shown, nullptr);
    EXPECT_EQ(made == nullptr, which == 3); // there is nothing to follow
    if (made) {
      EXPECT_EQ(made->GetNodeReference("InnerGSModel"), nullptr);
    }
  }
}

TEST_F(QueryTest, OutputRemovedByAnObserver) {
  vtkNew<vtkMatrix4x4> pose;
  for (const bool plane : {true, false}) {
    auto* output = addNode<vtkMRMLScalarVolumeNode>();
    Observer watch(scene, {vtkMRMLScene::NodeAddedEvent}, [&](unsigned long, void* data) {
      if (static_cast<vtkMRMLNode*>(data)->IsA("vtkMRMLDisplayNode")) scene->RemoveNode(output);
    });
    EXPECT_EQ(plane ? logic->QueryPlane(model, pose, 8, 8, 1, output) : logic->Resample(model, 4, output),
              nullptr);
  }
}

TEST_F(QueryTest, ResampledLikeAnImageWhoseExtentBeginsElsewhere) {
  auto* reference = addVolume("Reference");
  auto* plain = logic->ResampleLike(model, reference);
  ASSERT_NE(plain, nullptr);
  // The same voxels with another first index.
  const auto matrix = matrixOf(reference);
  double first[4] = {-3, -5, -7, 1};
  matrix->MultiplyPoint(first, first);
  for (int row = 0; row < 3; ++row)
    matrix->SetElement(row, 3, first[row]);
  reference->GetImageData()->SetExtent(3, 26, 5, 26, 7, 26);
  reference->SetIJKToRASMatrix(matrix);
  auto* shifted = logic->ResampleLike(model, reference);
  ASSERT_NE(shifted, nullptr) << logic->GetLastError();
  const auto a = matrixOf(plain), b = matrixOf(shifted);
  for (int n = 0; n < 16; ++n)
    EXPECT_NEAR(a->GetElement(n / 4, n % 4), b->GetElement(n / 4, n % 4), 1e-9);
  EXPECT_LT(error(shifted), 6);
}

TEST_F(QueryTest, UnderATransformThatScalesOrShears) {
  vtkNew<vtkMatrix4x4> scale, shear;
  scale->SetElement(0, 0, 2);
  auto* parent = addTransform(scale);
  model->SetAndObserveTransformNodeID(parent->GetID());
  auto* scaled = logic->Resample(model, 3);
  ASSERT_NE(scaled, nullptr) << logic->GetLastError();
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(scaled->GetSpacing()[axis], 3, 0.01); // mm in the world
  shear->SetElement(0, 1, 0.4);
  parent->SetMatrixTransformToParent(shear);
  EXPECT_EQ(logic->Resample(model, 3), nullptr);
  EXPECT_NE(logic->GetLastError().find("shears"), std::string::npos) << logic->GetLastError();
  vtkNew<vtkMatrix4x4> pose;
  auto* plane = logic->QueryPlane(model, pose, 9, 9, 2);
  ASSERT_NE(plane, nullptr) << logic->GetLastError();
  const auto toWorld = matrixOf(plane);
  for (const int i : {0, 3, 8}) {
    double at[4] = {double(i), double(8 - i / 2), 0, 1}, world[4];
    toWorld->MultiplyPoint(at, world);
    EXPECT_NEAR(plane->GetImageData()->GetScalarComponentAsDouble(i, 8 - i / 2, 0, 0),
                logic->GetValueAtRAS(model, world[0], world[1], world[2]), 0.1);
  }
  EXPECT_EQ(logic->ResampleLike(model, plane), nullptr);
  EXPECT_NE(logic->GetLastError().find("shears"), std::string::npos) << logic->GetLastError();
}

TEST_F(QueryTest, UnderATransformThatBends) {
  vtkNew<vtkPoints> from, to;
  for (int n = 0; n < 8; ++n) {
    const double at[3] = {n & 1 ? 20. : -20., n & 2 ? 20. : -20., n & 4 ? 20. : -20.};
    from->InsertNextPoint(at);
    to->InsertNextPoint(at[0] + 3 * (n == 3), at[1] - 2 * (n == 5), at[2] + 4);
  }
  vtkNew<vtkThinPlateSplineTransform> spline;
  spline->SetBasisToR();
  spline->SetSourceLandmarks(from);
  spline->SetTargetLandmarks(to);
  auto* parent = addNode<vtkMRMLTransformNode>("Bent");
  parent->SetAndObserveTransformToParent(spline);
  vtkNew<vtkTransform> turn;
  turn->RotateWXYZ(25, 0.2, 1, 0.4);
  parent->SetAndObserveTransformNodeID(addTransform(turn->GetMatrix())->GetID());
  double straight[6], bounds[6];
  model->GetRASBounds(straight);

  auto* slice = addNode<vtkMRMLSliceNode>("Red");
  slice->SetLayoutName("Red");
  slice->SetDimensions(30, 20, 1);
  slice->SetFieldOfView(30, 20, 1);
  auto* followed = logic->FollowSlice(model, slice);
  ASSERT_NE(followed, nullptr) << logic->GetLastError();
  model->SetAndObserveTransformNodeID(parent->GetID());
  model->GetRASBounds(bounds);
  EXPECT_GT(std::abs(bounds[5] - straight[5]), 1);
  auto* plane = logic->QueryPlane(model, turn->GetMatrix(), 21, 17, 1);
  ASSERT_NE(plane, nullptr) << logic->GetLastError();

  const auto expectBent = [&](vtkMRMLScalarVolumeNode* volume) {
    auto* fixed = addNode<vtkMRMLInnerGSModelNode>();
    fixed->SetModel(model->GetModel());
    vtkNew<vtkGeneralTransform> fromWorld;
    parent->GetTransformFromWorld(fromWorld);
    const auto toWorld = matrixOf(volume);
    const int* size = volume->GetImageData()->GetDimensions();
    for (int n = 0; n < size[0] * size[1]; n += 7) {
      double at[4] = {double(n % size[0]), double(n / size[0]), 0, 1};
      toWorld->MultiplyPoint(at, at);
      const double value = volume->GetImageData()->GetScalarComponentAsDouble(n % size[0], n / size[0], 0, 0);
      EXPECT_NEAR(value, logic->GetValueAtRAS(model, at[0], at[1], at[2]), 0.1);
      fromWorld->TransformPoint(at, at);
      EXPECT_NEAR(value, logic->GetValueAtRAS(fixed, at[0], at[1], at[2]), 0.1);
    }
    scene->RemoveNode(fixed);
  };
  expectBent(plane);
  expectBent(followed);
  to->SetPoint(0, -15, -22, -14);
  to->Modified();
  spline->Modified();
  expectBent(followed);
}

TEST_F(QueryTest, GaussiansAsAModelNode) {
  auto* node = logic->CreateGaussianModel(model, 50);
  ASSERT_NE(node, nullptr) << logic->GetLastError();
  EXPECT_EQ(node->GetPolyData()->GetNumberOfPoints(), 50);
  EXPECT_EQ(logic->CreateGaussianModel(model, 0, node), node);
  EXPECT_EQ(node->GetPolyData()->GetNumberOfPoints(), model->GetModel()->GetNumberOfGaussians());
}

TEST_F(QueryTest, OutputsSayWhatTheyWereMadeFrom) {
  auto* slice = addNode<vtkMRMLSliceNode>("Red");
  slice->SetLayoutName("Red");
  vtkNew<vtkMatrix4x4> pose;
  auto* plane = logic->QueryPlane(model, pose, 8, 8, 1);
  auto* resampled = logic->Resample(model, 3);
  const std::vector<vtkMRMLNode*> outputs = {plane, resampled, logic->ResampleLike(model, resampled),
                                             logic->FollowSlice(model, slice),
                                             logic->CreateGaussianModel(model, 20)};
  for (vtkMRMLNode* node : outputs) {
    ASSERT_NE(node, nullptr) << logic->GetLastError();
    SCOPED_TRACE(node->GetName());
    for (const char* name : {"InnerGS.Version", "InnerGS.Settings", "InnerGS.Inputs", "InnerGS.Device"}) {
      ASSERT_NE(model->GetAttribute(name), nullptr) << name;
      EXPECT_STREQ(node->GetAttribute(name), model->GetAttribute(name)) << name;
    }
    EXPECT_EQ(node->GetNodeReference("InnerGSModel"), model);
  }
  // From another model with fewer attributes: none of the first one's remain.
  auto* other = addNode<vtkMRMLInnerGSModelNode>();
  other->SetModel(model->GetModel());
  ASSERT_EQ(logic->QueryPlane(other, pose, 8, 8, 1, plane), plane);
  EXPECT_EQ(plane->GetAttribute("InnerGS.Settings"), nullptr);
  EXPECT_EQ(plane->GetAttribute("InnerGS.Version"), vtkSlicerInnerGSLogic::GetVersion());
  EXPECT_EQ(plane->GetNodeReference("InnerGSModel"), other);
}

} // namespace
