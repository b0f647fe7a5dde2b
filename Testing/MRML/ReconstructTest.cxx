#include "MrmlFixture.h"
#include "vtkInnerGSReconstruct.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLLinearTransformNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLSubjectHierarchyNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkClosedSurfaceToBinaryLabelmapConversionRule.h>
#include <vtkCollection.h>
#include <vtkDataArray.h>
#include <vtkOrientedImageData.h>
#include <vtkPointData.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>
#include <vtkSegmentationConverterFactory.h>
#include <vtkSphereSource.h>
#include <vtkTable.h>
#include <vtkTransform.h>

#include <sstream>
#include <utility>

namespace {

class ReconstructTest : public MrmlFixture {
protected:
  /// Axial and coronal slices of 4 mm.
  std::pair<vtkMRMLScalarVolumeNode*, vtkMRMLScalarVolumeNode*> addTwoScans() {
    const int axial[3] = {40, 40, 15}, coronal[3] = {40, 15, 40};
    const double across[3] = {1.5, 1.5, 4}, along[3] = {1.5, 4, 1.5};
    return {addCentredVolume("Axial", axial, across), addCentredVolume("Coronal", coronal, along)};
  }
};
using Parameters = vtkMRMLInnerGSParameterNode;

TEST_F(ReconstructTest, NewNodesBesideTheInput) {
  auto* input = addVolume();
  input->CreateDefaultDisplayNodes();
  auto* shown = vtkMRMLScalarVolumeDisplayNode::SafeDownCast(input->GetDisplayNode());
  shown->SetAutoWindowLevel(0);
  shown->SetWindowLevel(321, 123);
  auto* hierarchy = vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene);
  ASSERT_NE(hierarchy, nullptr);
  const vtkIdType study = hierarchy->CreateFolderItem(hierarchy->GetSceneItemID(), "Study");
  hierarchy->CreateItem(study, input);
  const vtkMTimeType before = input->GetImageData()->GetMTime();

  auto* parameters = addParameters(input);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* job = logic->GetLastJob();
  auto* volume = job->GetVolumeNode();
  auto* model = job->GetModelNode();
  ASSERT_NE(volume, nullptr);
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(parameters->GetResultVolumeNode(), volume);
  EXPECT_EQ(parameters->GetResultModelNode(), model);
  EXPECT_STREQ(volume->GetName(), "Head InnerGS");
  EXPECT_LT(error(volume), 6);
  EXPECT_GT(model->GetModel()->GetNumberOfGaussians(), 10);
  EXPECT_EQ(input->GetImageData()->GetMTime(), before);

  EXPECT_EQ(hierarchy->GetItemParent(hierarchy->GetItemByDataNode(volume)), study);
  EXPECT_EQ(hierarchy->GetItemParent(hierarchy->GetItemByDataNode(model)), study);
  auto* display = vtkMRMLScalarVolumeDisplayNode::SafeDownCast(volume->GetDisplayNode());
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(display->GetWindow(), 321);
  EXPECT_EQ(display->GetLevel(), 123);
  for (vtkMRMLNode* node : {static_cast<vtkMRMLNode*>(volume), static_cast<vtkMRMLNode*>(model)}) {
    EXPECT_STREQ(node->GetAttribute("InnerGS.Inputs"), "Head");
    EXPECT_EQ(node->GetAttribute("InnerGS.Version"), vtkSlicerInnerGSLogic::GetVersion());
    EXPECT_NE(std::string(node->GetAttribute("InnerGS.Settings")).find("preset=fast"), std::string::npos);
  }

  // Again: other new nodes, unless one was chosen.
  ASSERT_TRUE(logic->Reconstruct(parameters));
  auto* second = logic->GetLastJob()->GetVolumeNode();
  EXPECT_NE(second, volume);
  parameters->SetOutputVolumeNode(second);
  parameters->SetOutputModelNode(model);
  ASSERT_TRUE(logic->Reconstruct(parameters));
  EXPECT_EQ(logic->GetLastJob()->GetVolumeNode(), second);
  EXPECT_EQ(logic->GetLastJob()->GetModelNode(), model);
  EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 3);
}

// Without Slicer's application nothing else removes them; leftovers are mistaken for later nodes.
TEST_F(ReconstructTest, SaysWhatLiesBetweenSlices) {
  ASSERT_TRUE(logic->Reconstruct(addParameters(addThickVolume()))) << logic->GetLastError();
  auto* job = logic->GetLastJob();
  EXPECT_NE(job->GetPredictionNote(), "");
  EXPECT_EQ(job->GetAgreementNote(), "");
}

TEST_F(ReconstructTest, RemovedOutputsLeaveTheHierarchy) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(2);
  auto* hierarchy = vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene);
  ASSERT_NE(hierarchy, nullptr);
  int complaints = 0;
  Observer listen(hierarchy, {vtkCommand::ErrorEvent}, [&](unsigned long, void*) { ++complaints; });
  for (int n = 0; n < 8; ++n) {
    const int before = hierarchy->GetNumberOfItems();
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    EXPECT_EQ(hierarchy->GetNumberOfItems(), before + 2);
    scene->RemoveNode(logic->GetLastJob()->GetVolumeNode());
    scene->RemoveNode(logic->GetLastJob()->GetModelNode());
    EXPECT_EQ(hierarchy->GetNumberOfItems(), before);
  }
  EXPECT_EQ(complaints, 0);
}

TEST_F(ReconstructTest, SettingsReachTheEngine) {
  auto* parameters = addParameters(addVolume());
  const auto forEachAsked = [](auto&& use) {
    std::istringstream asked(
        "selection=method2 schedule=plateau plateauPatience=3 plateauFactor=0.25 plateauLowest=0.125 "
        "iterations=4 "
        "plateauThreshold=0.0625 densifyEvery=2 pruneOpacity=0.03125 pruneSize=12.5 densifyGradient=0.75 "
        "splitSize=3.5 cutoff=2.5 beta1=0.75 beta2=0.9375 device=cpu seed=18000000000000000001");
    for (std::string name; std::getline(asked, name, '=');) {
      std::string text;
      asked >> text >> std::ws;
      use(name, text);
    }
  };
  forEachAsked([&](auto& name, auto& text) { ASSERT_TRUE(parameters->SetSetting(name, text)) << name; });
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* model = logic->GetLastJob()->GetModelNode();
  const std::string used = std::string("; ") + model->GetAttribute("InnerGS.Settings") + ";";
  forEachAsked([&](auto& name, auto& text) {
    EXPECT_NE(used.find("; " + name + "=" + text + ";"), std::string::npos) << name << " not in " << used;
  });
  EXPECT_STREQ(model->GetAttribute("InnerGS.Device"), "cpu");
}

TEST_F(ReconstructTest, OutputGrids) {
  auto* input = addThickVolume();
  auto* parameters = addParameters(input);
  const auto sizeOf = [&] {
    EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    int size[3] = {0, 0, 0};
    if (auto* volume = logic->GetLastJob()->GetVolumeNode()) volume->GetImageData()->GetDimensions(size);
    return std::array<int, 3>{size[0], size[1], size[2]};
  };
  using Size = std::array<int, 3>;
  EXPECT_EQ(sizeOf(), (Size{32, 30, 33})); // isotropic at the finest spacing
  parameters->SetOutputGrid(Parameters::InputGrid);
  EXPECT_EQ(sizeOf(), (Size{32, 30, 10}));
  const auto in = matrixOf(input), out = matrixOf(logic->GetLastJob()->GetVolumeNode());
  for (int n = 0; n < 16; ++n)
    EXPECT_NEAR(in->GetData()[n], out->GetData()[n], 1e-9);
  parameters->SetOutputGrid(Parameters::SpacingGrid);
  parameters->SetOutputSpacing(3);
  EXPECT_EQ(sizeOf(), (Size{16, 15, 17}));
  parameters->SetOutputGrid(Parameters::ReferenceGrid);
  const int size[3] = {9, 8, 7};
  const double spacing[3] = {2, 2, 2.5}, origin[3] = {-8, -7, -6};
  auto matrix = oblique(20, spacing, origin);
  parameters->SetReferenceVolumeNode(addVolume("Reference", size, matrix));
  EXPECT_EQ(sizeOf(), (Size{9, 8, 7}));
  logic->GetLastJob()->GetVolumeNode()->GetIJKToRASMatrix(out);
  for (int n = 0; n < 16; ++n)
    EXPECT_NEAR(matrix->GetData()[n], out->GetData()[n], 1e-9);
  EXPECT_LT(error(logic->GetLastJob()->GetVolumeNode(), 0), 25);
}

TEST_F(ReconstructTest, SeveralStacks) {
  auto* axial = addThickVolume("Axial");
  const int size[3] = {10, 30, 32};
  vtkNew<vtkMatrix4x4> matrix;
  const double spacing[3] = {5, 1.5, 1.5};
  for (int a = 0; a < 3; ++a) {
    matrix->SetElement(a, a, spacing[a]);
    matrix->SetElement(a, 3, -spacing[a] * (size[a] - 1) / 2);
  }
  auto* sagittal = addVolume("Sagittal", size, matrix);
  auto* parameters = addParameters(axial);
  parameters->AddInputVolumeNode(sagittal);
  parameters->AddInputVolumeNode(sagittal); // adding it once more changes nothing
  ASSERT_EQ(parameters->GetNumberOfInputVolumeNodes(), 2);
  parameters->SetInputSliceThickness(sagittal, 4.5);
  parameters->SetInputSliceProfile(sagittal, Parameters::GaussianProfile);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  EXPECT_STREQ(volume->GetAttribute("InnerGS.Inputs"), "Axial; Sagittal");
  EXPECT_NE(logic->GetLastJob()->GetAgreementNote(), "");
  EXPECT_LT(error(volume, 4), 15);
}

TEST_F(ReconstructTest, SlicesLieWhereASequenceOfTransformsSays) {
  auto* input = addThickVolume();
  auto* sequence = addNode<vtkMRMLSequenceNode>("Poses");
  vtkNew<vtkMRMLLinearTransformNode> transform;
  vtkNew<vtkMatrix4x4> matrix;
  const auto setPoses = [&](double shift, int count) {
    sequence->RemoveAllDataNodes();
    matrix->SetElement(1, 3, shift);
    transform->SetMatrixTransformToParent(matrix);
    for (int k = 0; k < count; ++k)
      sequence->SetDataNodeAtValue(transform, std::to_string(k));
  };
  auto* parameters = addParameters(input);
  parameters->SetInputSlicePosesNode(input, sequence);
  parameters->SetNumberOfIterations(5);
  const auto originOf = [&](double shift) {
    setPoses(shift, 10);
    EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    vtkNew<vtkMatrix4x4> grid;
    logic->GetLastJob()->GetVolumeNode()->GetIJKToRASMatrix(grid);
    return grid->GetElement(1, 3);
  };
  const double before = originOf(0);
  EXPECT_NEAR(originOf(7.5) - before, 7.5, 1e-6);

  setPoses(0, 9);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("slice poses"), std::string::npos) << logic->GetLastError();
  sequence->SetDataNodeAtValue(input, "volume");
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("linear transform"), std::string::npos) << logic->GetLastError();
  scene->RemoveNode(sequence);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("in the scene"), std::string::npos) << logic->GetLastError();
  parameters->SetInputSlicePosesNode(input, nullptr);
  EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
}

TEST_F(ReconstructTest, MaskAndRegion) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  auto* mask = addNode<vtkMRMLLabelMapVolumeNode>();
  vtkNew<vtkImageData> labels;
  labels->SetDimensions(24, 22, 20);
  labels->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  labels->GetPointData()->GetScalars()->Fill(0);
  for (int k = 5; k < 15; ++k)
    for (int j = 5; j < 15; ++j)
      for (int i = 5; i < 15; ++i)
        labels->SetScalarComponentFromDouble(i, j, k, 0, 3);
  mask->SetAndObserveImageData(labels);
  mask->SetName("Label");
  parameters->SetFillValue(-321);
  const auto matrix = matrixOf(input);
  // On its own, and elsewhere under a transform that moves it back.
  vtkNew<vtkTransform> away;
  away->Translate(150, -200, 90);
  away->RotateZ(90);
  vtkNew<vtkMatrix4x4> back, moved;
  vtkMatrix4x4::Invert(away->GetMatrix(), back);
  vtkMatrix4x4::Multiply4x4(away->GetMatrix(), matrix, moved);
  double bounds[6];
  for (const bool transformed : {false, true}) {
    SCOPED_TRACE(transformed);
    mask->SetIJKToRASMatrix(transformed ? moved.Get() : matrix.Get());
    mask->SetAndObserveTransformNodeID(transformed ? addTransform(back)->GetID() : nullptr);
    parameters->SetMaskNode(mask);
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    auto* model = logic->GetLastJob()->GetModelNode();
    const auto wrong = [&](double r, double a, double s) {
      return std::abs(logic->GetValueAtRAS(model, r, a, s) - truth(r, a, s));
    };
    for (double r : {-9.0, 1.0}) { // the label reaches from -13 to 5, -11 to 7, -9 to 9
      EXPECT_LT(wrong(r, -5, -3), 12) << r;
      EXPECT_LT(wrong(r, 2, 4), 12) << r;
    }
    for (double s : {-17.0, 17.0}) {
      EXPECT_EQ(logic->GetValueAtRAS(model, 19, 17, s), -321) << s;
      EXPECT_EQ(logic->GetValueAtRAS(model, -21, -19, s), -321) << s;
    }
    EXPECT_STREQ(model->GetAttribute("InnerGS.Mask"), "Label");
    int cut[3];
    logic->GetLastJob()->GetVolumeNode()->GetImageData()->GetDimensions(cut);
    EXPECT_LT(cut[0], 24) << "the label's box and a slice";
    EXPECT_GE(cut[0], 10);
  }
  parameters->SetMaskNode(nullptr);
  ASSERT_TRUE(logic->Reconstruct(parameters))
      << logic->GetLastError(); // without it, the same positions are right
  EXPECT_EQ(logic->GetLastJob()->GetModelNode()->GetAttribute("InnerGS.Mask"), nullptr);
  EXPECT_NEAR(logic->GetValueAtRAS(logic->GetLastJob()->GetModelNode(), 19, 17, 17), truth(19, 17, 17), 20);

  auto* roi = addNode<vtkMRMLMarkupsROINode>();
  roi->SetCenter(2, -1, 3);
  roi->SetSize(20, 16, 12);
  parameters->SetROINode(roi);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  int size[3];
  volume->GetImageData()->GetDimensions(size);
  EXPECT_EQ(size[0], 10);
  EXPECT_EQ(size[1], 8);
  EXPECT_EQ(size[2], 6);
  volume->GetRASBounds(bounds);
  EXPECT_NEAR(bounds[0], -8, 1e-6);
  EXPECT_NEAR(bounds[5], 9, 1e-6);
  EXPECT_LT(error(volume, 1), 8);
  parameters->SetMaskNode(mask);
  EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
}

TEST_F(ReconstructTest, SegmentationAsMask) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  auto* node = addNode<vtkMRMLSegmentationNode>("Organs");
  parameters->SetMaskNode(node);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("'Organs' is empty"), std::string::npos) << logic->GetLastError();
  const auto matrix = matrixOf(input);
  for (int size : {6, 16}) {
    vtkNew<vtkOrientedImageData> labels;
    labels->SetDimensions(24, 22, 20);
    labels->SetImageToWorldMatrix(matrix);
    labels->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
    labels->GetPointData()->GetScalars()->Fill(0);
    for (int k = 4; k < 4 + size; ++k)
      for (int j = 4; j < 4 + size; ++j)
        for (int i = 4; i < 4 + size; ++i)
          labels->SetScalarComponentFromDouble(i, j, k, 0, 1);
    vtkNew<vtkSegment> segment;
    segment->AddRepresentation(vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName(),
                               labels);
    ASSERT_TRUE(node->GetSegmentation()->AddSegment(segment, "Size" + std::to_string(size)));
  }
  for (const bool all : {false, true}) {
    parameters->SetMaskSegmentID(all ? "" : "Size6");
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    auto* model = logic->GetLastJob()->GetModelNode();
    EXPECT_NEAR(logic->GetValueAtRAS(model, -10, -8, -6), truth(-10, -8, -6), 8); // in both segments
    const double far =
        std::abs(logic->GetValueAtRAS(model, 11, 13, 15) - truth(11, 13, 15)); // in the large one
    if (all) {
      EXPECT_LT(far, 8);
    } else {
      EXPECT_GT(far, 16);
    }
  }
  parameters->SetMaskSegmentID("None such");
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("None such"), std::string::npos);
}

// Segments from a surface have no voxels until they are shown in a slice view.
TEST_F(ReconstructTest, SegmentationOfSurfacesAsMask) {
  auto* rules = vtkSegmentationConverterFactory::GetInstance(); // filled by the Segmentations module
  if (rules->GetConverterRules().empty())
    rules->RegisterConverterRule(vtkSmartPointer<vtkClosedSurfaceToBinaryLabelmapConversionRule>::New());
  auto* parameters = addParameters(addVolume());
  auto* node = addNode<vtkMRMLSegmentationNode>("Ball");
  vtkNew<vtkTransform> move;
  move->Translate(4, 0, 0);
  node->SetAndObserveTransformNodeID(addTransform(move->GetMatrix())->GetID());
  vtkNew<vtkSphereSource> sphere;
  sphere->SetCenter(-12, -6, -6);
  sphere->SetRadius(9);
  sphere->SetThetaResolution(24);
  sphere->SetPhiResolution(24);
  sphere->Update();
  const std::string surface = vtkSegmentationConverter::GetSegmentationClosedSurfaceRepresentationName();
  node->GetSegmentation()->SetSourceRepresentationName(surface);
  vtkNew<vtkSegment> segment;
  segment->AddRepresentation(surface, sphere->GetOutput());
  ASSERT_TRUE(node->GetSegmentation()->AddSegment(segment, "Ball"));
  parameters->SetMaskNode(node);
  for (const char* which : {"", "Ball"}) {
    parameters->SetMaskSegmentID(which);
    ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    auto* model = logic->GetLastJob()->GetModelNode();
    EXPECT_NEAR(logic->GetValueAtRAS(model, -8, -6, -6), truth(-8, -6, -6), 12);
    EXPECT_GT(std::abs(logic->GetValueAtRAS(model, 15, 15, 15) - truth(15, 15, 15)), 30);
    EXPECT_FALSE(node->GetSegmentation()->ContainsRepresentation(
        vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName())); // it is unchanged
  }
}

TEST_F(ReconstructTest, UncertaintyIsAVolumeBesideTheResult) {
  auto* input = addLargerVolume();
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(10);
  parameters->SetOutputGrid(vtkMRMLInnerGSParameterNode::SpacingGrid);
  parameters->SetOutputSpacing(1.2);
  parameters->SetInputSliceThickness(input, 1); // so that some voxels lie between the slices
  parameters->EstimateUncertaintyOn();
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* job = logic->GetLastJob();
  auto* volume = job->GetVolumeNode();
  auto* model = job->GetModelNode();
  auto* deviation = job->GetUncertaintyNode();
  ASSERT_NE(deviation, nullptr) << job->GetWarning(job->GetNumberOfWarnings() - 1);
  EXPECT_STREQ(deviation->GetName(), "Larger InnerGS standard deviation");
  EXPECT_EQ(parameters->GetResultUncertaintyNode(), deviation);
  EXPECT_EQ(deviation->GetNodeReference("InnerGSModel"), model);
  EXPECT_EQ(deviation->GetNodeReference("InnerGSVolume"), volume);
  EXPECT_EQ(deviation->GetAttribute("InnerGS.Uncertainty"), job->GetUncertaintyNote());
  EXPECT_GT(job->GetUncertaintyCoverage(), 0.8);
  const auto ofVolume = matrixOf(volume), ofDeviation = matrixOf(deviation);
  for (int i = 0; i < 16; ++i)
    EXPECT_EQ(ofVolume->GetElement(i / 4, i % 4), ofDeviation->GetElement(i / 4, i % 4));
  double range[2];
  deviation->GetImageData()->GetScalarRange(range);
  EXPECT_GT(range[0], 0);
  auto* display = vtkMRMLScalarVolumeDisplayNode::SafeDownCast(deviation->GetDisplayNode());
  ASSERT_NE(display, nullptr);
  EXPECT_FALSE(display->GetAutoWindowLevel());
  EXPECT_EQ(display->GetWindowLevelMin(), 0);
  EXPECT_GT(display->GetWindowLevelMax(), range[0]);
  EXPECT_LE(display->GetWindowLevelMax(), range[1]);

  // Where some slice measured the tissue: a labelmap, which tells it of the deviation once it was saved.
  auto* measured = job->GetMeasuredNode();
  ASSERT_NE(measured, nullptr);
  EXPECT_STREQ(measured->GetName(), "Larger InnerGS measured");
  EXPECT_EQ(deviation->GetNodeReference("InnerGSMeasured"), measured);
  EXPECT_EQ(measured->GetNodeReference("InnerGSModel"), model);
  for (int i = 0; i < 16; ++i)
    EXPECT_EQ(ofVolume->GetElement(i / 4, i % 4), matrixOf(measured)->GetElement(i / 4, i % 4));
  vtkPointData* points = deviation->GetImageData()->GetPointData();
  const vtkSmartPointer<vtkDataArray> said = points->GetArray("Measured");
  vtkDataArray* labels = measured->GetImageData()->GetPointData()->GetScalars();
  ASSERT_EQ(labels->GetNumberOfTuples(), said->GetNumberOfTuples());
  double labelled[2];
  labels->GetRange(labelled);
  EXPECT_EQ(labelled[0], 0);
  EXPECT_EQ(labelled[1], 1);
  points->RemoveArray("Measured");
  {
    vtkNew<vtkMatrix4x4> plane;
    ASSERT_NE(logic->QueryUncertaintyPlane(model, plane, 3, 3, 1), nullptr) << logic->GetLastError();
  }
  ASSERT_NE(points->GetArray("Measured"), nullptr);
  for (vtkIdType n = 0; n < said->GetNumberOfTuples(); ++n)
    ASSERT_EQ(points->GetArray("Measured")->GetComponent(n, 0), said->GetComponent(n, 0)) << n;

  // On a plane through a voxel, also of a model that was moved.
  const double ijk[4] = {12, 20, 9, 1};
  for (const double moved : {0., 7.}) {
    vtkNew<vtkMatrix4x4> shift, plane;
    shift->SetElement(1, 3, moved);
    model->SetAndObserveTransformNodeID(addTransform(shift)->GetID());
    double at[4];
    ofDeviation->MultiplyPoint(ijk, at);
    for (int a = 0; a < 3; ++a)
      plane->SetElement(a, 3, at[a] + (a == 1 ? moved : 0));
    auto* shown = logic->QueryUncertaintyPlane(model, plane, 3, 3, 1);
    ASSERT_NE(shown, nullptr) << logic->GetLastError();
    EXPECT_NEAR(shown->GetImageData()->GetScalarComponentAsDouble(1, 1, 0, 0),
                deviation->GetImageData()->GetScalarComponentAsDouble(12, 20, 9, 0), 1e-3);
    EXPECT_EQ(shown->GetNodeReference("InnerGSModel"), model);
  }

  // Into a chosen node; and without it, nothing refers to one.
  parameters->SetOutputModelNode(model);
  parameters->SetOutputUncertaintyNode(deviation);
  parameters->SetSeed(3);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetUncertaintyNode(), deviation);
  EXPECT_EQ(logic->GetLastJob()->GetMeasuredNode(), measured);
  parameters->EstimateUncertaintyOff();
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetUncertaintyNode(), nullptr);
  EXPECT_EQ(parameters->GetResultUncertaintyNode(), nullptr);
  vtkNew<vtkMatrix4x4> plane;
  EXPECT_EQ(logic->QueryUncertaintyPlane(model, plane, 3, 3, 1), nullptr);
  EXPECT_NE(logic->GetLastError().find("is not known"), std::string::npos);
  parameters->SetOutputUncertaintyNode(vtkMRMLScalarVolumeNode::SafeDownCast(input));
  EXPECT_NE(logic->CheckParameters(parameters), "");
}

TEST_F(ReconstructTest, QualityTable) {
  auto* parameters = addParameters(addVolume());
  parameters->SetHeldOutFraction(0.2);
  parameters->EvaluateQualityOn();
  parameters->SetQualityGap(2);
  std::vector<double> progress;
  Observer watch(logic, {vtkSlicerInnerGSLogic::JobProgressEvent}, [&](unsigned long, void* job) {
    progress.push_back(static_cast<vtkSlicerInnerGSJob*>(job)->GetProgress());
  });
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  auto* table = logic->GetLastJob()->GetTableNode();
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(parameters->GetResultTableNode(), table);
  ASSERT_EQ(table->GetTable()->GetNumberOfRows(), 4);
  EXPECT_EQ(table->GetTable()->GetValueByName(0, "Method").ToString(), "gaussians");
  EXPECT_EQ(table->GetTable()->GetValueByName(1, "Method").ToString(), "linear");
  EXPECT_GT(table->GetTable()->GetValueByName(0, "PSNR (dB)").ToDouble(), 20);
  EXPECT_STREQ(table->GetAttribute("InnerGS.Protocol"), "H, keep-every-2");
  EXPECT_EQ(table->GetNodeReference("InnerGSModel"), logic->GetLastJob()->GetModelNode());
  EXPECT_EQ(table->GetNodeReference("InnerGSVolume"), logic->GetLastJob()->GetVolumeNode());
  EXPECT_GT(logic->GetLastJob()->GetHeldOutPSNR(), 20);
  EXPECT_EQ(logic->GetLastJob()->GetNumberOfHeldOutSlices(), 4);
  EXPECT_EQ(logic->GetLastJob()->GetQualityState(), vtkInnerGSReconstruct::QualityMeasured);
  EXPECT_STRNE(table->GetAttribute("InnerGS.HeldOutPSNR"), nullptr);
  // With the quality judged in both ways, the result is the one fitted to all slices.
  const vtkSmartPointer<vtkImageData> judged = logic->GetLastJob()->GetVolumeNode()->GetImageData();
  parameters->SetHeldOutFraction(0);
  parameters->EvaluateQualityOff();
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetQualityState(), vtkInnerGSReconstruct::QualityNotAsked);
  vtkImageData* plain = logic->GetLastJob()->GetVolumeNode()->GetImageData();
  EXPECT_EQ(std::memcmp(judged->GetScalarPointer(), plain->GetScalarPointer(),
                        sizeof(float) * static_cast<std::size_t>(plain->GetNumberOfPoints())),
            0);
}

TEST_F(ReconstructTest, GivesSlicesATableAndTransforms) {
  auto [axial, coronal] = addTwoScans();
  coronal->SetOrigin(coronal->GetOrigin()[0] + 2, coronal->GetOrigin()[1], coronal->GetOrigin()[2]);
  auto* parameters = addParameters(axial);
  parameters->AddInputVolumeNode(coronal);
  parameters->SetSetting("sliceMotion", "on");
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* job = logic->GetLastJob();
  vtkMRMLTableNode* table = job->GetSliceTableNode();
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(parameters->GetResultSliceTableNode(), table);
  EXPECT_STREQ(table->GetName(), "Axial InnerGS slices");
  EXPECT_EQ(table->GetNodeReference("InnerGSModel"), job->GetModelNode());
  ASSERT_EQ(table->GetTable()->GetNumberOfRows(), 15 + 15);
  EXPECT_EQ(table->GetTable()->GetValueByName(15, "Scan").ToInt(), 2);
  EXPECT_EQ(table->GetTable()->GetValueByName(15, "Slice").ToInt(), 0);

  vtkNew<vtkCollection> transforms;
  ASSERT_TRUE(logic->CreateSliceTransforms(table, transforms)) << logic->GetLastError();
  ASSERT_EQ(transforms->GetNumberOfItems(), 15 + 15);
  auto* hierarchy = vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene);
  double between = 0; // mm to the right, from the axial slices' motion to the coronal ones'
  for (int row = 0; row < 30; ++row) {
    auto* transform = vtkMRMLLinearTransformNode::SafeDownCast(transforms->GetItemAsObject(row));
    ASSERT_EQ(transform->GetScene(), scene.Get());
    vtkNew<vtkMatrix4x4> matrix;
    transform->GetMatrixTransformToWorld(matrix);
    EXPECT_NEAR(matrix->Determinant(), 1, 1e-9);
    EXPECT_EQ(matrix->GetElement(1, 3), table->GetTable()->GetValueByName(row, "M13").ToDouble());
    if (row % 15 > 3 && row % 15 < 11) between += (row < 15 ? -1 : 1) * matrix->GetElement(0, 3) / 7;
    const vtkIdType folder = hierarchy->GetItemParent(hierarchy->GetItemByDataNode(transform));
    EXPECT_EQ(hierarchy->GetItemName(folder), "Axial InnerGS slices transforms");
  }
  EXPECT_NEAR(between, -2, 0.5) << "back by what the header is off";
  EXPECT_STREQ(vtkMRMLNode::SafeDownCast(transforms->GetItemAsObject(18))->GetName(), "Scan 2 slice 003");

  vtkNew<vtkMRMLTableNode> other;
  scene->AddNode(other);
  EXPECT_FALSE(logic->CreateSliceTransforms(other));
  EXPECT_NE(logic->GetLastError().find("has no places of slices"), std::string::npos);
  EXPECT_FALSE(logic->CreateSliceTransforms(nullptr));
  parameters->SetSetting("sliceMotion", "off");
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetSliceTableNode(), nullptr);
  EXPECT_EQ(parameters->GetResultSliceTableNode(), nullptr);
}

TEST_F(ReconstructTest, EveryScanHasAMaskOfItsOwn) {
  auto [axial, coronal] = addTwoScans();
  auto* parameters = addParameters(axial);
  parameters->AddInputVolumeNode(coronal);
  parameters->SetSetting("align", "false");
  parameters->SetSetting("sliceMotion", "off");
  parameters->SetSetting("ignorePadding", "false"); // which would leave it out as well
  // To the left the axial scan shows something else, which its own mask leaves out.
  auto* inside = addNode<vtkMRMLLabelMapVolumeNode>("Right");
  vtkNew<vtkImageData> labels;
  labels->SetDimensions(40, 40, 15);
  labels->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  for (int k = 0; k < 15; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        labels->SetScalarComponentFromDouble(i, j, k, 0, i >= 20);
        if (i < 20) axial->GetImageData()->SetScalarComponentFromDouble(i, j, k, 0, 2000);
      }
  inside->SetAndObserveImageData(labels);
  const auto matrix = matrixOf(axial);
  inside->SetIJKToRASMatrix(matrix);
  vtkNew<vtkOrientedImageData> whole;
  whole->SetDimensions(40, 15, 40);
  whole->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  whole->GetPointData()->GetScalars()->Fill(1);
  coronal->GetIJKToRASMatrix(matrix);
  whole->SetImageToWorldMatrix(matrix);
  auto* all = addNode<vtkMRMLSegmentationNode>("Whole");
  vtkNew<vtkSegment> segment;
  segment->AddRepresentation(vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName(),
                             whole);
  ASSERT_TRUE(all->GetSegmentation()->AddSegment(segment, "Whole"));
  const auto wrong = [&] { // where only the coronal scan is right
    auto* model = logic->GetLastJob()->GetModelNode();
    return std::abs(logic->GetValueAtRAS(model, -12, 3, -5) - truth(-12, 3, -5));
  };

  parameters->SetInputMaskNode(axial, inside);
  EXPECT_EQ(logic->CheckParameters(parameters).find("'Coronal' has no mask"), 0u);
  parameters->SetInputMaskNode(coronal, all);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(wrong(), 15);
  EXPECT_STREQ(logic->GetLastJob()->GetModelNode()->GetAttribute("InnerGS.Mask"), "Right; Whole");
  EXPECT_GT(logic->EstimateMemory(parameters), 0);

  parameters->SetMaskNode(all); // of the scans without one of their own
  parameters->SetInputMaskNode(coronal, nullptr);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_LT(wrong(), 15);
  EXPECT_STREQ(logic->GetLastJob()->GetModelNode()->GetAttribute("InnerGS.Mask"), "Right; Whole");
  parameters->SetInputMaskNode(axial, nullptr); // for both
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_GT(wrong(), 100);
  EXPECT_STREQ(logic->GetLastJob()->GetModelNode()->GetAttribute("InnerGS.Mask"), "Whole");

  // A mask that lies beside its scan.
  parameters->SetInputMaskNode(axial, inside);
  matrix->SetElement(0, 3, 900);
  inside->SetIJKToRASMatrix(matrix);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("The mask of Axial holds no centre of its finite voxels"),
            std::string::npos)
      << logic->GetLastError();
  scene->RemoveNode(inside);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_EQ(logic->GetLastError(), "The mask of 'Axial' is no longer in the scene: choose another.");
}

} // namespace
