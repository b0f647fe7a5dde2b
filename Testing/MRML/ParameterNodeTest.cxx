#include "MrmlFixture.h"

#include <vtkMRMLTableNode.h>

namespace {

using ParameterNodeTest = MrmlFixture;
using Parameters = vtkMRMLInnerGSParameterNode;

void fill(Parameters* p) {
  p->SetPreset(Parameters::Best);
  p->SetBlending(Parameters::Additive);
  p->SetLinearIntensity(0);
  p->SetInitialisation(Parameters::Grid);
  p->SetLoss(Parameters::Huber);
  p->SetHuberDelta(1.0 / 3);
  p->SetSSIMWeight(0.123456789012345);
  p->SetNumberOfGaussians(123456);
  p->SetNumberOfIterations(77);
  p->SetEnsembleSize(3);
  p->SetPaperStopRule(1);
  p->SetAllAxes(1);
  p->SetSchedule(Parameters::Plateau);
  p->SetDensifyEvery(9);
  p->SetMaximumNumberOfGaussians(99999);
  p->SetPointWeight(0.8);
  p->SetSelection(Parameters::Method2);
  p->SetPlateauPatience(7);
  p->SetPlateauFactor(0.3);
  p->SetPlateauLowest(0.02);
  p->SetPlateauThreshold(2e-4);
  p->SetPruneOpacity(0.05);
  p->SetPruneSize(12.5);
  p->SetDensifyGradient(0.75);
  p->SetSplitSize(3.5);
  p->SetFillValue(-1024);
  p->SetCutoff(2.3);
  p->SetBeta1(0.81);
  p->SetBeta2(0.97);
  p->SetDevice("cuda:1");
  p->RelocateOff();
  p->ConsistencyOff();
  p->SetNumberOfThreads(2);
  p->SetInstructionSet("scalar");
  p->SetSeed(42);
  p->SetHeldOutFraction(0.1);
  p->EvaluateQualityOn();
  p->SetQualityGap(6);
  p->SetOutputGrid(Parameters::SpacingGrid);
  p->SetOutputSpacing(0.7);
  p->SetMaskSegmentID("Segment \"1\" <&>");
}

void expectFilled(Parameters* p) {
  EXPECT_EQ(p->GetPreset(), Parameters::Best);
  EXPECT_EQ(p->GetBlending(), Parameters::Additive);
  EXPECT_EQ(p->GetLinearIntensity(), 0);
  EXPECT_EQ(p->GetInitialisation(), Parameters::Grid);
  EXPECT_EQ(p->GetLoss(), Parameters::Huber);
  EXPECT_EQ(p->GetHuberDelta(), 1.0 / 3);
  EXPECT_EQ(p->GetSSIMWeight(), 0.123456789012345);
  EXPECT_EQ(p->GetNumberOfGaussians(), 123456);
  EXPECT_EQ(p->GetNumberOfIterations(), 77);
  EXPECT_EQ(p->GetEnsembleSize(), 3);
  EXPECT_EQ(p->GetPaperStopRule(), 1);
  EXPECT_EQ(p->GetAllAxes(), 1);
  EXPECT_EQ(p->GetSchedule(), Parameters::Plateau);
  EXPECT_EQ(p->GetDensifyEvery(), 9);
  EXPECT_EQ(p->GetMaximumNumberOfGaussians(), 99999);
  EXPECT_EQ(p->GetPointWeight(), 0.8);
  EXPECT_EQ(p->GetSelection(), Parameters::Method2);
  EXPECT_EQ(p->GetPlateauPatience(), 7);
  EXPECT_EQ(p->GetPlateauFactor(), 0.3);
  EXPECT_EQ(p->GetPlateauLowest(), 0.02);
  EXPECT_EQ(p->GetPlateauThreshold(), 2e-4);
  EXPECT_EQ(p->GetPruneOpacity(), 0.05);
  EXPECT_EQ(p->GetPruneSize(), 12.5);
  EXPECT_EQ(p->GetDensifyGradient(), 0.75);
  EXPECT_EQ(p->GetSplitSize(), 3.5);
  EXPECT_EQ(p->GetFillValue(), -1024);
  EXPECT_EQ(p->GetCutoff(), 2.3);
  EXPECT_EQ(p->GetBeta1(), 0.81);
  EXPECT_EQ(p->GetBeta2(), 0.97);
  EXPECT_EQ(p->GetDevice(), "cuda:1");
  EXPECT_FALSE(p->GetRelocate());
  EXPECT_FALSE(p->GetConsistency());
  EXPECT_EQ(p->GetNumberOfThreads(), 2);
  EXPECT_EQ(p->GetInstructionSet(), "scalar");
  EXPECT_EQ(p->GetSeed(), 42);
  EXPECT_EQ(p->GetHeldOutFraction(), 0.1);
  EXPECT_TRUE(p->GetEvaluateQuality());
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
  parameters->SetQualityTableNode(
      vtkMRMLTableNode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLTableNode")));
  fill(parameters);
  scene->SetSaveToXMLString(1);
  scene->Commit();
  const std::string xml = scene->GetSceneXMLString();

  // Into a scene that has nodes with the same IDs already: references are renamed, and what hangs on them
  // too.
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
  EXPECT_EQ(target->GetNumberOfGaussians(), 0);
  EXPECT_LT(target->GetPruneOpacity(), 0);
  EXPECT_EQ(target->GetCutoff(), Parameters::Automatic);
  EXPECT_EQ(target->GetBeta1(), Parameters::Automatic);
  EXPECT_EQ(target->GetBeta2(), Parameters::Automatic);
  EXPECT_EQ(target->GetDevice(), "auto");
  EXPECT_EQ(target->GetMaskSegmentID(), "Segment \"1\" <&>"); // the input's, not a setting
  EXPECT_EQ(source->GetSeed(), 42);
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
