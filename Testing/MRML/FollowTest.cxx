#include "QueryFixture.h"

#include <vtkMRMLSliceNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkPoints.h>
#include <vtkThinPlateSplineTransform.h>
#include <vtkTransform.h>

namespace {

using FollowTest = QueryTest;

TEST_F(FollowTest, FollowsASliceView) {
  auto* slice = addNode<vtkMRMLSliceNode>("Red");
  slice->SetLayoutName("Red");
  slice->SetOrientation("Axial");
  slice->SetDimensions(40, 30, 1);
  slice->SetFieldOfView(30, 22.5, 1);
  auto* volume = logic->FollowSlice(model, slice);
  ASSERT_NE(volume, nullptr) << logic->GetLastError();
  EXPECT_TRUE(logic->IsFollowing(volume));
  EXPECT_LT(error(volume, 0), 6);
  vtkNew<vtkMatrix4x4> before, after;
  volume->GetIJKToRASMatrix(before);
  slice->SetSliceOffset(5);
  volume->GetIJKToRASMatrix(after);
  EXPECT_NEAR(after->GetElement(2, 3) - before->GetElement(2, 3), 5, 1e-6);
  EXPECT_LT(error(volume, 0), 6);
  vtkNew<vtkTransform> turn;
  turn->RotateWXYZ(30, 1, 0.5, 0);
  slice->GetSliceToRAS()->DeepCopy(turn->GetMatrix());
  slice->UpdateMatrices();
  EXPECT_LT(error(volume, 0), 6);

  logic->SetMaximumFollowPixels(16); // for views that are larger
  ASSERT_EQ(logic->FollowSlice(model, slice, volume), volume);
  int size[3];
  volume->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 16);
  EXPECT_LT(error(volume, 0), 6);

  // The model moves while its view stays.
  vtkNew<vtkTransform> shift;
  shift->Translate(0, 0, 4);
  const double was = volume->GetImageData()->GetScalarComponentAsDouble(8, 6, 0, 0);
  model->SetAndObserveTransformNodeID(addTransform(shift->GetMatrix())->GetID());
  EXPECT_NE(volume->GetImageData()->GetScalarComponentAsDouble(8, 6, 0, 0), was);

  scene->RemoveNode(slice);
  EXPECT_FALSE(logic->IsFollowing(volume));
}

TEST_F(FollowTest, FollowedSliceSaysWhatTheNewModelWasMadeFrom) {
  auto* slice = addNode<vtkMRMLSliceNode>();
  slice->SetLayoutName("Red");
  auto* volume = logic->FollowSlice(model, slice);
  ASSERT_NE(volume, nullptr) << logic->GetLastError();
  EXPECT_STREQ(volume->GetAttribute("InnerGS.Settings"), model->GetAttribute("InnerGS.Settings"));
  auto* parameters = addParameters(addVolume("Other"));
  parameters->SetSeed(77);
  parameters->SetOutputModelNode(model);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_NE(std::string(volume->GetAttribute("InnerGS.Settings")).find("seed=77"), std::string::npos);
  EXPECT_STREQ(volume->GetAttribute("InnerGS.Inputs"), "Other");
}

// Otherwise the next move of the view would overwrite it.
TEST_F(FollowTest, FollowingEndsWhenTheOutputGetsSomethingElse) {
  auto* slice = addNode<vtkMRMLSliceNode>();
  slice->SetLayoutName("Red");
  auto* other = addNode<vtkMRMLSliceNode>();
  other->SetLayoutName("Green");
  auto* reference = addVolume("Reference");
  auto* parameters = addParameters(reference);
  parameters->SetNumberOfIterations(2);
  vtkNew<vtkMatrix4x4> plane;
  for (int which = 0; which < 4; ++which) {
    SCOPED_TRACE(which);
    auto* volume = logic->FollowSlice(model, slice);
    auto* untouched = logic->FollowSlice(model, other);
    ASSERT_NE(volume, nullptr) << logic->GetLastError();
    if (which == 0) {
      EXPECT_EQ(logic->QueryPlane(model, nullptr, 9, 9, 2, volume), nullptr); // nothing is stored in it
      EXPECT_TRUE(logic->IsFollowing(volume));
      EXPECT_EQ(logic->QueryPlane(model, plane, 9, 9, 2, volume), volume);
    } else if (which == 1) {
      EXPECT_EQ(logic->Resample(model, 3, volume), volume);
    } else if (which == 2) {
      EXPECT_EQ(logic->ResampleLike(model, reference, volume), volume);
    } else {
      parameters->SetOutputVolumeNode(volume);
      ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    }
    EXPECT_FALSE(logic->IsFollowing(volume));
    EXPECT_TRUE(logic->IsFollowing(untouched));
    const vtkMTimeType made = volume->GetImageData()->GetMTime();
    slice->SetSliceOffset(slice->GetSliceOffset() + 3);
    EXPECT_EQ(volume->GetImageData()->GetMTime(), made);
  }
}

TEST_F(FollowTest, FollowingEndsWithAnyNode) {
  for (int which = 0; which < 3; ++which) {
    auto* slice = addNode<vtkMRMLSliceNode>();
    slice->SetLayoutName(("View" + std::to_string(which)).c_str());
    auto* copy = addNode<vtkMRMLInnerGSModelNode>();
    copy->CopyContent(model);
    auto* volume = logic->FollowSlice(copy, slice);
    ASSERT_NE(volume, nullptr) << logic->GetLastError();
    vtkMRMLNode* const nodes[] = {slice, copy, volume};
    scene->RemoveNode(nodes[which]);
    if (which > 0) slice->SetSliceOffset(3); // nothing observes it
    EXPECT_FALSE(which != 2 && logic->IsFollowing(volume));
  }
}

// Observers of the output and of errors may end the following themselves.
TEST_F(FollowTest, FollowingEndedByAnObserver) {
  for (int which = 0; which < 4; ++which) {
    const vtkSmartPointer<vtkMRMLSliceNode> slice = addNode<vtkMRMLSliceNode>();
    slice->SetLayoutName(("Watched" + std::to_string(which)).c_str());
    slice->SetDimensions(20, 20, 1);
    auto* copy = addNode<vtkMRMLInnerGSModelNode>();
    copy->CopyContent(model);
    vtkSmartPointer<vtkMRMLScalarVolumeNode> volume = logic->FollowSlice(copy, slice);
    ASSERT_NE(volume, nullptr) << logic->GetLastError();
    int seen = 0;
    const auto end = [&](unsigned long, void*) {
      if (++seen > 1) return;
      if (which == 0) logic->StopFollowing(volume);
      if (which == 1) scene->RemoveNode(volume);
      if (which == 2) scene->RemoveNode(slice);
      if (which == 3) logic->StopFollowing();
    };
    Observer image(which < 3 ? static_cast<vtkObject*>(volume) : logic.Get(),
                   {which < 3 ? static_cast<unsigned long>(vtkMRMLVolumeNode::ImageDataModifiedEvent)
                              : static_cast<unsigned long>(vtkCommand::ErrorEvent)},
                   end);
    if (which < 3)
      slice->SetSliceOffset(3);
    else
      copy->SetModel(nullptr);
    EXPECT_GT(seen, 0) << which;
    EXPECT_FALSE(logic->IsFollowing(volume)) << which;
  }
}

TEST_F(FollowTest, RefusedFollowingChangesNothing) {
  auto* slice = addNode<vtkMRMLSliceNode>();
  slice->SetLayoutName("Refused");
  slice->SetDimensions(20, 20, 1);
  auto* volume = logic->FollowSlice(model, slice);
  ASSERT_NE(volume, nullptr);
  const int nodes = scene->GetNumberOfNodes();
  slice->GetXYToRAS()->Zero(); // not a plane
  EXPECT_EQ(logic->FollowSlice(model, slice), nullptr);
  EXPECT_EQ(scene->GetNumberOfNodes(), nodes);
  EXPECT_EQ(logic->FollowSlice(model, slice, volume), nullptr);
  EXPECT_TRUE(logic->IsFollowing(volume));
}

// Under a nonlinear transform, the first plane has few pixels; the full one follows once the view rests.
TEST_F(FollowTest, InFullAtRest) {
  vtkNew<vtkPoints> from, to;
  for (int n = 0; n < 8; ++n) {
    const double at[3] = {n & 1 ? 20. : -20., n & 2 ? 20. : -20., n & 4 ? 20. : -20.};
    from->InsertNextPoint(at);
    to->InsertNextPoint(at[0] + 3 * (n == 3), at[1], at[2]);
  }
  vtkNew<vtkThinPlateSplineTransform> spline;
  spline->SetBasisToR();
  spline->SetSourceLandmarks(from);
  spline->SetTargetLandmarks(to);
  auto* parent = addNode<vtkMRMLTransformNode>("Bent");
  parent->SetAndObserveTransformToParent(spline);
  model->SetAndObserveTransformNodeID(parent->GetID());
  auto* slice = addNode<vtkMRMLSliceNode>("Red");
  slice->SetLayoutName("Red");
  slice->SetOrientation("Coronal");
  slice->SetDimensions(400, 300, 1);
  slice->SetFieldOfView(40, 30, 1);
  auto* volume = logic->FollowSlice(model, slice);
  ASSERT_NE(volume, nullptr) << logic->GetLastError();
  const auto columnsOf = [](vtkMRMLVolumeNode* node) { return node->GetImageData()->GetDimensions()[0]; };
  const auto pumpUntilInFull = [&](vtkMRMLVolumeNode* node) {
    waitUntil([&] {
      logic->ProcessPendingEvents();
      return columnsOf(node) == 400;
    });
  };
  EXPECT_LT(columnsOf(volume), 400);
  const auto waitInFull = [&] {
    pumpUntilInFull(volume);
    ASSERT_EQ(volume->GetImageData()->GetDimensions()[1], 300);
    const auto toWorld = matrixOf(volume);
    for (int n = 0; n < 30; ++n) {
      const int i = 13 * n, j = 7 * n;
      double at[4] = {double(i), double(j), 0, 1};
      toWorld->MultiplyPoint(at, at);
      EXPECT_NEAR(volume->GetImageData()->GetScalarComponentAsDouble(i, j, 0, 0),
                  logic->GetValueAtRAS(model, at[0], at[1], at[2]), 0.1);
    }
  };
  waitInFull();
  slice->SetSliceOffset(3);
  waitInFull();
  slice->SetSliceOffset(5); // none for a view no longer followed
  vtkSmartPointer<vtkImageData> last = volume->GetImageData();
  logic->StopFollowing(volume);
  pumpUntilInFull(logic->FollowSlice(model, slice)); // requested later, arrives later
  EXPECT_EQ(volume->GetImageData(), last);
}

} // namespace
