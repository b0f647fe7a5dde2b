#include "Core/Base/SystemMemory.h"
#include "Core/Job/JobOutline.h"
#include "MrmlFixture.h"
#include "vtkInnerGSAlgorithm.h"

#include <vtkMRMLBSplineTransformNode.h>
#include <vtkMRMLGridTransformNode.h>
#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSliceNode.h>
#include <vtkMRMLVectorVolumeNode.h>

#include <vtkFloatArray.h>
#include <vtkOrientedGridTransform.h>
#include <vtkOrientedImageData.h>
#include <vtkPoints.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>

#include <cmath>
#include <limits>
#include <thread>

namespace {

using Parameters = vtkMRMLInnerGSParameterNode;

class BadInputTest : public MrmlFixture {
protected:
  /// The reconstruction is rejected or fails with a message that contains the words; one ErrorEvent, no new
  /// node, unchanged outputs.
  void expectError(Parameters* parameters, const std::string& words, int code = 0) {
    errors.clear();
    const int before = scene->GetNumberOfNodes();
    EXPECT_FALSE(logic->Reconstruct(parameters)) << words;
    EXPECT_NE(logic->GetLastError().find(words), std::string::npos) << logic->GetLastError();
    ASSERT_EQ(errors.size(), 1u) << words;
    EXPECT_NE(errors[0].find(words), std::string::npos) << errors[0];
    EXPECT_EQ(scene->GetNumberOfNodes(), before);
    EXPECT_EQ(logic->GetNumberOfJobs(), 0);
    ASSERT_FALSE(logic->GetLastError().empty());
    EXPECT_EQ(logic->GetLastError().back(), '.');
    if (code != 0)
      EXPECT_EQ(logic->GetLastErrorCode(), code) << words;
    else
      EXPECT_NE(logic->GetLastErrorCode(), 0) << words;
  }
};

TEST_F(BadInputTest, MissingAndWrongNodes) {
  expectError(nullptr, "no parameter node");
  vtkNew<Parameters> loose;
  expectError(loose, "not in the scene");
  auto* parameters = addParameters(nullptr);
  expectError(parameters, "no input volume");
  auto* model = scene->AddNewNodeByClass("vtkMRMLModelNode", "Surface");
  parameters->AddNodeReferenceID(Parameters::GetInputVolumeReferenceRole(), model->GetID());
  expectError(parameters, "'Surface' is not a scalar volume");
  parameters->RemoveAllInputVolumeNodes();
  parameters->AddNodeReferenceID(Parameters::GetInputVolumeReferenceRole(), "vtkMRMLScalarVolumeNodeGone");
  expectError(parameters, "no longer in the scene");
  auto* labels = scene->AddNewNodeByClass("vtkMRMLLabelMapVolumeNode", "Labels");
  parameters->SetInputVolumeNode(vtkMRMLVolumeNode::SafeDownCast(labels));
  expectError(parameters, "labelmap");

  auto* input = addVolume();
  parameters->SetInputVolumeNode(input);
  parameters->SetMaskNode(model);
  expectError(parameters, "neither a labelmap nor a segmentation");
  parameters->SetMaskNode(labels);
  expectError(parameters, "'Labels' has no voxels");
  parameters->SetMaskNode(nullptr);
  parameters->SetROINode(model);
  expectError(parameters, "not a markups ROI");
  parameters->SetROINode(scene->AddNewNodeByClass("vtkMRMLMarkupsROINode", "Box"));
  expectError(parameters, "empty");
  parameters->SetROINode(nullptr);
  parameters->SetOutputVolumeNode(input);
  expectError(parameters, "an input as well");
  parameters->SetOutputVolumeNode(vtkMRMLScalarVolumeNode::SafeDownCast(labels));
  expectError(parameters, "labelmap");
  parameters->SetOutputVolumeNode(nullptr);
  parameters->SetOutputGrid(Parameters::ReferenceGrid);
  expectError(parameters, "no reference volume");
  parameters->SetOutputGrid(Parameters::SpacingGrid);
  parameters->SetOutputSpacing(0);
  expectError(parameters, "above 0 mm");
  parameters->SetOutputSpacing(std::numeric_limits<double>::quiet_NaN());
  expectError(parameters, "above 0 mm");
  EXPECT_EQ(logic->EstimateMemory(parameters), 0);
  EXPECT_NE(logic->CheckParameters(parameters), "");
  parameters->SetOutputSpacing(2);
  EXPECT_EQ(logic->CheckParameters(parameters), "");
  EXPECT_GT(logic->EstimateMemory(parameters), 0);
}

TEST_F(BadInputTest, EstimatesAndChecksLookAtNoVoxels) {
  auto* parameters = addParameters(addThickVolume());
  parameters->SetDevice("cpu");
  parameters->SetNumberOfIterations(20);
  parameters->SetSetting("prediction", "none");
  const double seconds = logic->EstimateSeconds(parameters);
  EXPECT_GT(seconds, 0);
  parameters->SetEnsembleSize(5);
  const double members = logic->EstimateSeconds(parameters);
  EXPECT_GT(members, seconds);
  parameters->SetEvaluateQuality(true);
  EXPECT_GT(logic->EstimateSeconds(parameters), members);
  // An empty segment is detected only by looking at its voxels.
  auto* segmentation = addNode<vtkMRMLSegmentationNode>("Nothing");
  vtkNew<vtkSegment> segment;
  segment->AddRepresentation(vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName(),
                             vtkNew<vtkOrientedImageData>());
  ASSERT_TRUE(segmentation->GetSegmentation()->AddSegment(segment, "Empty"));
  parameters->SetMaskNode(segmentation);
  EXPECT_EQ(logic->CheckParameters(parameters), "");
  EXPECT_GT(logic->EstimateMemory(parameters), 0);
  EXPECT_GT(logic->EstimateSeconds(parameters), 0);
  expectError(parameters, "'Nothing' is empty");
  EXPECT_EQ(logic->EstimateSeconds(nullptr), 0);
}

// For panels, which must not wait.
TEST_F(BadInputTest, EstimateOnAnotherThread) {
  auto* parameters = addParameters(addThickVolume());
  parameters->SetDevice("cpu");
  parameters->SetNumberOfIterations(20);
  const auto keyNow = [&] {
    std::string key;
    EXPECT_TRUE(logic->EstimateLater(parameters, &key));
    return key;
  };
  std::string key;
  const auto later = logic->EstimateLater(parameters, &key);
  ASSERT_TRUE(later);
  scene->RemoveNode(parameters->GetInputVolumeNode(0)); // it knows no nodes
  innergs::JobForecast estimate;
  std::thread([&] { estimate = later(); }).join();
  EXPECT_GT(estimate.seconds, 0);
  EXPECT_TRUE(std::isfinite(estimate.seconds));
  EXPECT_NE(estimate.reason.find("as asked"), std::string::npos) << estimate.reason;
  EXPECT_FALSE(logic->EstimateLater(parameters, nullptr)); // nothing is left to estimate

  parameters->SetInputVolumeNode(addThickVolume("The same again"));
  EXPECT_EQ(keyNow(), key);
  parameters->SetEvaluateQuality(true);
  EXPECT_NE(keyNow(), key);
  parameters->SetEvaluateQuality(false);
  parameters->SetEnsembleSize(5);
  EXPECT_NE(keyNow(), key);
}

TEST_F(BadInputTest, Images) {
  auto* parameters = addParameters(nullptr);
  auto* empty = addNode<vtkMRMLScalarVolumeNode>("Empty");
  parameters->SetInputVolumeNode(empty);
  expectError(parameters, "'Empty' has no voxels");
  vtkNew<vtkImageData> nothing;
  empty->SetAndObserveImageData(nothing);
  expectError(parameters, "'Empty' has no voxels");

  auto* colours = addNode<vtkMRMLVectorVolumeNode>("Colours");
  vtkNew<vtkImageData> rgb;
  rgb->SetDimensions(8, 8, 8);
  rgb->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  colours->SetAndObserveImageData(rgb);
  parameters->SetInputVolumeNode(colours);
  expectError(parameters, "3 values per voxel", vtkInnerGSAlgorithm::UnsupportedImageError);

  auto* bad = addNode<vtkMRMLScalarVolumeNode>("NaN");
  vtkNew<vtkImageData> nan;
  nan->SetDimensions(8, 8, 8);
  nan->AllocateScalars(VTK_FLOAT, 1);
  nan->GetPointData()->GetScalars()->Fill(std::numeric_limits<double>::quiet_NaN());
  bad->SetAndObserveImageData(nan);
  parameters->SetInputVolumeNode(bad);
  expectError(parameters, "finite", vtkInnerGSAlgorithm::NoDataError); // found by the worker
  EXPECT_EQ(logic->GetLastJob()->GetErrorCode(), vtkInnerGSAlgorithm::NoDataError);

  vtkNew<vtkImageData> slice;
  slice->SetDimensions(8, 8, 1);
  slice->AllocateScalars(VTK_FLOAT, 1);
  slice->GetPointData()->GetScalars()->Fill(1);
  bad->SetAndObserveImageData(slice);
  expectError(parameters, "single slice", vtkInnerGSAlgorithm::UnsupportedImageError);

  // Two scans that do not overlap.
  auto* far = addVolume("Far");
  const auto matrix = matrixOf(far);
  matrix->SetElement(0, 3, 5000);
  far->SetIJKToRASMatrix(matrix);
  parameters->SetInputVolumeNode(addVolume());
  parameters->AddInputVolumeNode(far);
  expectError(parameters, "overlap", vtkInnerGSAlgorithm::GeometryError);
  parameters->SetInputVolumeNode(addVolume());
  EXPECT_TRUE(logic->Reconstruct(parameters));
  EXPECT_EQ(logic->GetLastErrorCode(), 0);
}

TEST_F(BadInputTest, Transforms) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  vtkNew<vtkMatrix4x4> flat;
  flat->SetElement(2, 2, 0);
  auto* node = addTransform(flat, "Flat");
  input->SetAndObserveTransformNodeID(node->GetID());
  expectError(parameters, "cannot be inverted");
  vtkNew<vtkMatrix4x4> shear;
  shear->SetElement(0, 1, 0.5);
  node->SetMatrixTransformToParent(shear);
  expectError(parameters, "shear");

  auto* grid = addNode<vtkMRMLGridTransformNode>("Bent");
  vtkNew<vtkOrientedGridTransform> bend;
  vtkNew<vtkImageData> field;
  field->SetDimensions(3, 3, 3);
  field->AllocateScalars(VTK_DOUBLE, 3);
  field->GetPointData()->GetScalars()->Fill(1.5);
  bend->SetDisplacementGridData(field);
  grid->SetAndObserveTransformToParent(bend);
  input->SetAndObserveTransformNodeID(grid->GetID());
  expectError(parameters, "bends space");
  input->SetAndObserveTransformNodeID(nullptr);
  EXPECT_EQ(logic->CheckParameters(parameters), "");

  ASSERT_TRUE(logic->Reconstruct(parameters));
  auto* model = logic->GetLastJob()->GetModelNode();
  model->SetAndObserveTransformNodeID(grid->GetID());
  EXPECT_FALSE(std::isnan(logic->GetValueAtRAS(model, 0, 0, 0))); // points and planes can follow it
  EXPECT_EQ(logic->Resample(model, 2), nullptr);
  EXPECT_NE(logic->GetLastError().find("bends space"), std::string::npos);
  EXPECT_EQ(logic->ResampleLike(model, input), nullptr);
  EXPECT_NE(logic->GetLastError().find("bends space"), std::string::npos);
  node->SetMatrixTransformToParent(flat);
  model->SetAndObserveTransformNodeID(node->GetID());
  EXPECT_TRUE(std::isnan(logic->GetValueAtRAS(model, 0, 0, 0)));
  EXPECT_NE(logic->GetLastError().find("cannot be inverted"), std::string::npos);
}

TEST_F(BadInputTest, Settings) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfGaussians(-4);
  expectError(parameters, "Gaussians");
  parameters->SetNumberOfGaussians(Parameters::Automatic);
  parameters->SetNumberOfIterations(0);
  expectError(parameters, "iterations");
  parameters->SetNumberOfIterations(Parameters::Automatic);
  parameters->SetHeldOutFraction(0.9);
  expectError(parameters, "held-out", vtkInnerGSAlgorithm::InvalidArgumentError);
  parameters->SetHeldOutFraction(0);
  parameters->EvaluateQualityOn();
  parameters->SetQualityGap(1);
  expectError(parameters, "2nd to 64th");
  parameters->EvaluateQualityOff();
  parameters->SetInputSliceThickness(parameters->GetInputVolumeNode(), -2);
  expectError(parameters, "thickness");
  parameters->SetInputSliceThickness(parameters->GetInputVolumeNode(), 400);
  expectError(parameters, "400 mm");
  parameters->SetInputSliceThickness(parameters->GetInputVolumeNode(), 0);
  parameters->SetInputSliceAxis(parameters->GetInputVolumeNode(), 7);
  expectError(parameters, "axis");
  parameters->SetInputSliceAxis(parameters->GetInputVolumeNode(), Parameters::Automatic);
}

// An error on the worker thread: chosen outputs stay unchanged.
TEST_F(BadInputTest, OutputsStayUntouched) {
  auto* parameters = addParameters(addVolume());
  auto* output = addVolume("Output");
  vtkImageData* image = output->GetImageData();
  parameters->SetOutputVolumeNode(output);
  parameters->SetInstructionSet("none such");
  int failed = 0;
  Observer watch(logic, {vtkSlicerInnerGSLogic::JobFailedEvent}, [&](unsigned long, void* data) {
    ++failed;
    EXPECT_EQ(static_cast<vtkSlicerInnerGSJob*>(data)->GetState(), vtkSlicerInnerGSJob::Failed);
    EXPECT_FALSE(static_cast<vtkSlicerInnerGSJob*>(data)->GetErrorMessage().empty());
  });
  const vtkMTimeType before = output->GetMTime();
  expectError(parameters, "none such");
  EXPECT_EQ(failed, 1);
  EXPECT_EQ(output->GetImageData(), image);
  EXPECT_EQ(output->GetMTime(), before);
}

TEST_F(BadInputTest, Queries) {
  EXPECT_TRUE(std::isnan(logic->GetValueAtRAS(nullptr, 0, 0, 0)));
  auto* empty = addNode<vtkMRMLInnerGSModelNode>("None");
  EXPECT_TRUE(std::isnan(logic->GetValueAtRAS(empty, 0, 0, 0)));
  EXPECT_NE(logic->GetLastError().find("'None' is empty"), std::string::npos);
  vtkNew<vtkMatrix4x4> plane;
  const int nodes = scene->GetNumberOfNodes();
  EXPECT_EQ(logic->QueryPlane(empty, plane, 10, 10, 1), nullptr);
  EXPECT_EQ(logic->Resample(empty), nullptr);
  EXPECT_EQ(logic->ResampleLike(empty, nullptr), nullptr);
  EXPECT_EQ(logic->FollowSlice(empty, nullptr), nullptr);
  EXPECT_EQ(logic->CreateGaussianModel(empty), nullptr);
  EXPECT_FALSE(logic->SaveModel(empty, (folder / "none.innergs").string()));
  EXPECT_EQ(logic->GetLastErrorCode(), vtkInnerGSAlgorithm::NoDataError);
  EXPECT_EQ(logic->LoadModel((folder / "none.innergs").string()), nullptr);
  EXPECT_EQ(logic->GetLastErrorCode(), vtkInnerGSAlgorithm::FileNotFoundError) << logic->GetLastError();
  EXPECT_EQ(scene->GetNumberOfNodes(), nodes);

  ASSERT_TRUE(logic->Reconstruct(addParameters(addVolume())));
  auto* model = logic->GetLastJob()->GetModelNode();
  EXPECT_EQ(logic->QueryPlane(model, nullptr, 10, 10, 1), nullptr);
  EXPECT_EQ(logic->QueryPlane(model, plane, 0, 10, 1), nullptr);
  EXPECT_EQ(logic->QueryPlane(model, plane, 10, 10, -1), nullptr);
  plane->SetElement(0, 0, 0);
  EXPECT_EQ(logic->QueryPlane(model, plane, 10, 10, 1), nullptr);
  EXPECT_EQ(logic->GetLastErrorCode(), vtkInnerGSAlgorithm::GeometryError) << logic->GetLastError();
  EXPECT_EQ(logic->Resample(model, -3), nullptr);
  EXPECT_FALSE(logic->GetValuesAtRAS(model, nullptr, nullptr));
  vtkNew<vtkFloatArray> values;
  vtkNew<vtkPoints> points;
  EXPECT_TRUE(logic->GetValuesAtRAS(model, points, values)); // none of them
  EXPECT_EQ(values->GetNumberOfTuples(), 0);
}

// Before the start, with the job's own message.
TEST_F(BadInputTest, MoreThanTheMemoryIsRefusedBeforehand) {
  if (innergs::availableMemory() == 0) GTEST_SKIP() << "This system does not say how much memory there is.";
  auto* parameters = addParameters(addVolume());
  parameters->SetOutputGrid(vtkMRMLInnerGSParameterNode::SpacingGrid);
  parameters->SetOutputSpacing(0.002); // some 10¹³ voxels
  EXPECT_GT(logic->EstimateMemory(parameters), vtkTypeInt64(1) << 42);
  const std::string refusal = logic->CheckParameters(parameters);
  EXPECT_EQ(refusal.find("The reconstruction needs about "), 0u) << refusal;
  EXPECT_FALSE(logic->Reconstruct(parameters));
  const std::string& sentence = logic->GetLastError(); // the available memory changes
  EXPECT_EQ(sentence.substr(0, sentence.find(", but only ")), refusal.substr(0, refusal.find(", but only ")))
      << sentence;
}

} // namespace
