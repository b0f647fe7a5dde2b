#include "MrmlFixture.h"
#include "SettingTexts.h"

#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>

namespace {

using ParameterNodeTest = MrmlFixture;
using Parameters = vtkMRMLInnerGSParameterNode;

void fill(Parameters* p) {
  for (const innergs::Setting& row : innergs::settingsTable())
    ASSERT_TRUE(p->SetSetting(row.name, innergs::test::otherText(row))) << row.name;
  p->SetFillValue(1.0 / 3);
  p->SetInstructionSet("\"none\" <&> such");
  p->SetHeldOutFraction(0.1);
  p->EvaluateQualityOn();
  p->EstimateUncertaintyOn();
  p->SetQualityGap(6);
  p->SetOutputGrid(Parameters::SpacingGrid);
  p->SetOutputSpacing(0.7);
  p->SetMaskSegmentID("Segment \"1\" <&>");
}

void expectFilled(Parameters* p) {
  vtkNew<Parameters> filled;
  fill(filled);
  for (const innergs::Setting& row : innergs::settingsTable())
    EXPECT_EQ(p->GetSetting(row.name), filled->GetSetting(row.name)) << row.name;
  EXPECT_EQ(p->GetFillValue(), 1.0 / 3);
  EXPECT_EQ(p->GetSeed(), 18000000000000000001u);
  EXPECT_EQ(p->GetHeldOutFraction(), 0.1);
  EXPECT_TRUE(p->GetEvaluateQuality());
  EXPECT_TRUE(p->GetEstimateUncertainty());
  EXPECT_EQ(p->GetQualityGap(), 6);
  EXPECT_EQ(p->GetOutputGrid(), Parameters::SpacingGrid);
  EXPECT_EQ(p->GetOutputSpacing(), 0.7);
  EXPECT_EQ(p->GetMaskSegmentID(), "Segment \"1\" <&>");
}

TEST_F(ParameterNodeTest, SavedAndRestoredWithTheScene) {
  auto* first = addVolume("First");
  auto* second = addVolume("Second");
  auto* parameters = addParameters(first);
  parameters->AddInputVolumeNode(second);
  parameters->SetInputSliceThickness(second, 3.3);
  parameters->SetInputSliceProfile(second, Parameters::GaussianProfile);
  parameters->SetInputSliceAxis(second, 1);
  parameters->SetReferenceVolumeNode(first);
  parameters->SetMaskNode(second);
  parameters->SetInputMaskNode(second, first);
  parameters->SetInputSlicePosesNode(first, addNode<vtkMRMLSequenceNode>("Poses"));
  parameters->SetQualityTableNode(addNode<vtkMRMLTableNode>());
  fill(parameters);
  scene->SetSaveToXMLString(1);
  scene->Commit();
  const std::string xml = scene->GetSceneXMLString();

  // Imported into a scene that already has nodes with the same IDs: references are renamed, and everything
  // that depends on them too.
  vtkNew<vtkMRMLScene> other;
  vtkNew<vtkSlicerInnerGSLogic> otherLogic;
  otherLogic->SetMRMLScene(other);
  other->AddNewNodeByClass("vtkMRMLScalarVolumeNode", "Here before");
  other->AddNewNodeByClass("vtkMRMLScalarVolumeNode", "Here before too");
  other->SetLoadFromXMLString(1);
  other->SetSceneXMLString(xml);
  other->Import();
  auto* restored = Parameters::SafeDownCast(other->GetFirstNodeByClass("vtkMRMLInnerGSParameterNode"));
  ASSERT_NE(restored, nullptr);
  expectFilled(restored);
  ASSERT_EQ(restored->GetNumberOfInputVolumeNodes(), 2);
  auto* input = restored->GetInputVolumeNode(1);
  ASSERT_NE(input, nullptr);
  EXPECT_STREQ(input->GetName(), "Second");
  EXPECT_EQ(restored->GetInputSliceThickness(input), 3.3);
  EXPECT_EQ(restored->GetInputSliceProfile(input), Parameters::GaussianProfile);
  EXPECT_EQ(restored->GetInputSliceAxis(input), 1);
  EXPECT_EQ(restored->GetInputSliceThickness(restored->GetInputVolumeNode(0)), 0);
  EXPECT_STREQ(restored->GetReferenceVolumeNode()->GetName(), "First");
  ASSERT_NE(restored->GetMaskNode(), nullptr);
  EXPECT_STREQ(restored->GetMaskNode()->GetName(), "Second");
  ASSERT_NE(restored->GetInputMaskNode(input), nullptr);
  EXPECT_STREQ(restored->GetInputMaskNode(input)->GetName(), "First");
  EXPECT_FALSE(restored->HasInputMask(restored->GetInputVolumeNode(0)));
  EXPECT_FALSE(restored->HasInputSlicePoses(input));
  auto* poses = restored->GetInputSlicePosesNode(restored->GetInputVolumeNode(0));
  ASSERT_NE(poses, nullptr);
  EXPECT_STREQ(poses->GetName(), "Poses");
  EXPECT_NE(restored->GetQualityTableNode(), nullptr);
}

TEST_F(ParameterNodeTest, CopiedAndReset) {
  vtkNew<Parameters> source, target;
  fill(source);
  target->CopyContent(source);
  expectFilled(target);
  target->ResetSettings();
  EXPECT_EQ(target->GetPreset(), Parameters::Balanced);
  EXPECT_EQ(target->GetBlending(), Parameters::Automatic);
  EXPECT_EQ(target->GetNumberOfGaussians(), Parameters::Automatic);
  EXPECT_EQ(target->GetDevice(), "auto");
  EXPECT_TRUE(target->GetSettings() == innergs::Settings());
  EXPECT_EQ(target->GetMaskSegmentID(), "Segment \"1\" <&>"); // the input's, not a setting
  expectFilled(source);
}

TEST_F(ParameterNodeTest, SettingsHaveOneSpellingAndOneUnset) {
  vtkNew<Parameters> node;
  int errors = 0, changes = 0;
  Observer failed(node, {vtkCommand::ErrorEvent}, [&](unsigned long, void*) { ++errors; });
  Observer changed(node, {vtkCommand::ModifiedEvent}, [&](unsigned long, void*) { ++changes; });
  for (const char* text : {"2.5", "2.5", "9", "nan", "2,5"})
    node->SetSetting("cutoff", text);
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(errors, 3);
  EXPECT_EQ(node->GetSetting("cutoff"), "2.5");
  EXPECT_TRUE(node->UnsetSetting("cutoff"));
  EXPECT_EQ(node->GetSetting("cutoff"), "");
  node->SetNumberOfIterations(30);
  EXPECT_EQ(node->GetSetting("iterations"), "30");
  node->SetNumberOfIterations(Parameters::Automatic);
  EXPECT_EQ(node->GetSetting("iterations"), "");
  EXPECT_EQ(changes, 4);
}

/// As written by version 0.1: other names, choices as numbers, -1 and 0 for unset.
TEST_F(ParameterNodeTest, ReadsScenesOfOldVersions) {
  const std::string start = R"(<MRML version="Slicer4.4.0" userTags="">
 <InnerGSParameters id="vtkMRMLInnerGSParameterNode1" name="Old" preset="2")";
  const std::string end = R"( seed="42" heldOutFraction="0.1"></InnerGSParameters></MRML>)";
  const auto read = [&](const std::string& attributes) {
    scene->SetLoadFromXMLString(1);
    scene->SetSceneXMLString(start + attributes + end);
    EXPECT_TRUE(scene->Connect());
    return Parameters::SafeDownCast(scene->GetFirstNodeByClass("vtkMRMLInnerGSParameterNode"));
  };
  auto* unset = read(
      R"( blending="-1" linearIntensity="-1" initialisation="-1" loss="-1" huberDelta="0.02" ssimWeight="-1" numberOfGaussians="0" numberOfIterations="0" numberOfMembers="0" paperStopRule="-1" allAxes="-1" schedule="-1" densifyEvery="-1" maximumNumberOfGaussians="0" pointWeight="-1" selection="0" plateauPatience="10" plateauFactor="0.5" plateauLowest="0.01" plateauThreshold="0.0001" pruneOpacity="-1" pruneSize="20" densifyGradient="1" splitSize="2" cutoff="-1" beta1="-1" beta2="-1" device="auto" relocate="true" consistency="true" fillValue="0" numberOfThreads="0" instructionSet="")");
  ASSERT_NE(unset, nullptr);
  innergs::Settings expected;
  expected.preset = innergs::Preset::Best;
  expected.seed = 42;
  EXPECT_TRUE(unset->GetSettings() == expected);
  EXPECT_EQ(unset->GetHeldOutFraction(), 0.1);
  auto* set = read(
      R"( blending="1" linearIntensity="0" initialisation="1" loss="2" huberDelta="0.3333333333333333" ssimWeight="0" numberOfGaussians="1000" numberOfIterations="77" numberOfMembers="3" paperStopRule="1" allAxes="0" schedule="1" densifyEvery="0" maximumNumberOfGaussians="2000" pointWeight="0.8" selection="2" plateauPatience="7" pruneOpacity="0.05" cutoff="2.3" beta1="0.81" device="cuda:1" relocate="false" consistency="false" fillValue="-1024" numberOfThreads="2" instructionSet="scalar")");
  ASSERT_NE(set, nullptr);
  expected.device = "cuda:1";
  expected.fill = -1024;
  expected.blending = innergs::Blending::Additive;
  expected.linearIntensity = false;
  expected.cutoff = 2.3;
  expected.initialisation = innergs::Initialisation::Grid;
  expected.gaussians = 1000;
  expected.ensembleSize = 3;
  expected.iterations = 77;
  expected.loss = innergs::LossKind::Huber;
  expected.lossWeight = 0.8;
  expected.ssimWeight = 0;
  expected.huberDelta = 0.3333333333333333;
  expected.allAxes = expected.relocate = expected.consistency = false;
  expected.schedule = innergs::Schedule::Plateau;
  expected.plateau.patience = 7;
  expected.beta1 = 0.81;
  expected.paperStopRule = true;
  expected.densifyEvery = 0;
  expected.densify.opacity = 0.05;
  expected.maxGaussians = 2000;
  expected.selection = innergs::Selection::Method2;
  expected.threads = 2;
  expected.instructionSet = "scalar";
  EXPECT_TRUE(set->GetSettings() == expected);
}

TEST_F(ParameterNodeTest, RemovedNodesAreForgotten) {
  auto* first = addVolume("First");
  auto* second = addVolume("Second");
  auto* parameters = addParameters(first);
  parameters->AddInputVolumeNode(second);
  scene->RemoveNode(first);
  ASSERT_EQ(parameters->GetNumberOfInputVolumeNodes(), 1);
  EXPECT_EQ(parameters->GetInputVolumeNode(), second);
  parameters->RemoveInputVolumeNode(second);
  EXPECT_EQ(parameters->GetNumberOfInputVolumeNodes(), 0);
}

} // namespace
