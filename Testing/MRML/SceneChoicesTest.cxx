// What a saved scene records about the panels and the slice views that show a model.
#include "SceneChoices.h"
#include "Cameras.h"
#include "MrmlFixture.h"

#include <vtkMRMLCameraNode.h>
#include <vtkMRMLSelectionNode.h>
#include <vtkMRMLSliceCompositeNode.h>

#include <vtkMath.h>

namespace {

namespace mrml = innergs::mrml;

/// A scene with the nodes that every application has: a selection node and a slice view's layers.
class SceneChoicesTest : public MrmlFixture {
protected:
  static vtkMRMLSliceCompositeNode* addSingletons(vtkMRMLScene* scene) {
    scene->AddNode(vtkNew<vtkMRMLSelectionNode>());
    vtkNew<vtkMRMLSliceCompositeNode> view;
    view->SetLayoutName("Red");
    view->SetSingletonTag("Red");
    return vtkMRMLSliceCompositeNode::SafeDownCast(scene->AddNode(view));
  }
};

TEST_F(SceneChoicesTest, ASavedSceneKnowsThem) {
  auto* view = addSingletons(scene);
  auto* scan = addVolume();
  addParameters(scan);
  auto* chosen = addParameters(scan);
  chosen->SetName("Chosen");
  scene->AddNewNodeByClass("vtkMRMLInnerGSModelNode", "Other");
  auto* model = addNode<vtkMRMLInnerGSModelNode>("Model");
  mrml::rememberChoices(scene, chosen, model);
  // The view shows the model's plane, which is not saved, in place of the scan.
  auto* plane = addNode<vtkMRMLScalarVolumeNode>("Plane");
  plane->SetSaveWithScene(0);
  view->SetBackgroundVolumeID(plane->GetID());
  mrml::rememberShownModel(view, model, scan);
  scene->SetURL((folder / "scene.mrml").string().c_str());
  ASSERT_TRUE(scene->Commit());

  vtkNew<vtkMRMLScene> reopened;
  auto* other = addSingletons(reopened);
  vtkNew<vtkSlicerInnerGSLogic> itsLogic;
  itsLogic->SetMRMLScene(reopened);
  reopened->SetURL((folder / "scene.mrml").string().c_str());
  ASSERT_TRUE(reopened->Connect());
  ASSERT_NE(mrml::chosenParameters(reopened), nullptr);
  EXPECT_STREQ(mrml::chosenParameters(reopened)->GetName(), "Chosen");
  ASSERT_NE(mrml::chosenModel(reopened), nullptr);
  EXPECT_STREQ(mrml::chosenModel(reopened)->GetName(), "Model");
  EXPECT_EQ(mrml::shownModel(other), mrml::chosenModel(reopened));
  // Until the plane is available again, the view shows its previous background.
  auto* background =
      other->GetBackgroundVolumeID() ? reopened->GetNodeByID(other->GetBackgroundVolumeID()) : nullptr;
  ASSERT_NE(background, nullptr);
  EXPECT_STREQ(background->GetName(), "Head");

  // What was remembered disappears with the scene or the node.
  reopened->RemoveNode(mrml::chosenModel(reopened));
  EXPECT_EQ(mrml::chosenModel(reopened), nullptr);
  EXPECT_EQ(mrml::shownModel(other), nullptr);
  reopened->Clear(0);
  EXPECT_EQ(mrml::chosenParameters(reopened), nullptr);
}

TEST_F(SceneChoicesTest, NothingIsRememberedForNull) {
  auto* view = addSingletons(scene);
  auto* parameters = addParameters(addVolume());
  auto* model = addNode<vtkMRMLInnerGSModelNode>();
  mrml::rememberChoices(scene, parameters, model);
  mrml::rememberShownModel(view, model, nullptr);
  EXPECT_EQ(mrml::chosenModel(scene), model);
  EXPECT_EQ(mrml::shownModel(view), model);
  mrml::rememberChoices(scene, parameters, nullptr);
  mrml::rememberShownModel(view, nullptr, nullptr);
  EXPECT_EQ(mrml::chosenParameters(scene), parameters);
  EXPECT_EQ(mrml::chosenModel(scene), nullptr);
  EXPECT_EQ(mrml::shownModel(view), nullptr);
  vtkNew<vtkMRMLScene> bare; // without an application
  mrml::rememberChoices(bare, nullptr, nullptr);
  EXPECT_EQ(mrml::chosenParameters(bare), nullptr);
  mrml::restoreBackgrounds(bare);
}

TEST_F(SceneChoicesTest, ABackgroundThatIsThereStays) {
  auto* view = addSingletons(scene);
  auto *before = addVolume("Before"), *now = addVolume("Now");
  auto* model = addNode<vtkMRMLInnerGSModelNode>();
  mrml::rememberShownModel(view, model, before);
  view->SetBackgroundVolumeID(now->GetID());
  mrml::restoreBackgrounds(scene);
  EXPECT_STREQ(view->GetBackgroundVolumeID(), now->GetID());
}

TEST_F(SceneChoicesTest, OnlyUntouchedCamerasAreFramed) {
  auto* untouched = addNode<vtkMRMLCameraNode>();
  auto* turned = addNode<vtkMRMLCameraNode>();
  turned->SetPosition(300, 300, 0);
  const double bounds[6] = {100, 180, -30, 50, 10, 50}; // radius 60 mm around (140, 10, 30)
  frameUntouchedCameras(scene, bounds);
  double focus[3], position[3];
  untouched->GetFocalPoint(focus);
  untouched->GetPosition(position);
  EXPECT_NEAR(focus[0], 140, 1e-9);
  EXPECT_NEAR(focus[1], 10, 1e-9);
  EXPECT_NEAR(focus[2], 30, 1e-9);
  // From the front, as before, at the distance at which the sphere around the box just fits.
  EXPECT_NEAR(position[0], 140, 1e-9);
  EXPECT_NEAR(position[2], 30, 1e-9);
  const double angle = vtkMath::RadiansFromDegrees(untouched->GetViewAngle());
  EXPECT_NEAR((position[1] - 10) * std::sin(angle / 2), 60, 1e-6);
  turned->GetFocalPoint(focus);
  EXPECT_EQ(focus[0], 0);
  // Once framed, the camera belongs to the user: the next result does not change it.
  const double elsewhere[6] = {0, 10, 0, 10, 0, 10};
  frameUntouchedCameras(scene, elsewhere);
  untouched->GetFocalPoint(focus);
  EXPECT_NEAR(focus[0], 140, 1e-9);
}

} // namespace
