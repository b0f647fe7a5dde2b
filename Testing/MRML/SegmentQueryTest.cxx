#include "Core/Features/FeatureTraining.h"
#include "Core/Model/Model.h"
#include "SegmentationFixture.h"
#include "vtkInnerGSSegment.h"

#include <vtkMRMLColorTableNode.h>
#include <vtkMRMLLabelMapVolumeDisplayNode.h>
#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLVectorVolumeNode.h>

#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkVariant.h>
#include <vtksys/SystemTools.hxx>

#include <cmath>
#include <fstream>

namespace {

/// A model, and a segmentation of three balls to learn from.
class SegmentQueryTest : public SegmentationFixture {
protected:
  SegmentQueryTest() {
    vtksys::SystemTools::UnPutEnv("INNERGS_TEXT_MODEL"); // the lexicon alone answers
    auto* parameters = addParameters(input);
    parameters->SetNumberOfIterations(20);
    EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
    model = logic->GetLastJob()->GetModelNode();
    const auto matrix = matrixOf(input);
    const int whole[6] = {0, 23, 0, 21, 0, 19};
    truth = balls(matrix, whole, VTK_SHORT, {{-8, -4, -5, 9}, {9, 8, -5, 8}, {8, -9, 6, 7}});
    const char* const names[] = {"liver", "kidney_left", "kidney_right"};
    for (int n = 0; n < 3; ++n) {
      addSegment(names[n], truth, n + 1);
      segments->GetSegment(names[n])->SetName(names[n]);
    }
  }
  /// Overlap of a segment with a label of the truth, voxel by voxel of the segment's grid, which is that
  /// of the truth.
  double dice(vtkMRMLSegmentationNode* found, const std::string& name, int label) {
    std::vector<std::string> ids;
    found->GetSegmentation()->GetSegmentIDs(ids);
    vtkOrientedImageData* image = nullptr;
    for (const std::string& id : ids)
      if (name == found->GetSegmentation()->GetSegment(id)->GetName())
        image = vtkOrientedImageData::SafeDownCast(
            found->GetSegmentation()->GetSegment(id)->GetRepresentation(kLabelmap));
    if (!image) return -1;
    vtkNew<vtkMatrix4x4> imageToNode, nodeToTruth, toTruth;
    image->GetImageToWorldMatrix(imageToNode);
    truth->GetImageToWorldMatrix(nodeToTruth);
    nodeToTruth->Invert();
    vtkMatrix4x4::Multiply4x4(nodeToTruth, imageToNode, toTruth);
    double both = 0, either = 0;
    int e[6];
    truth->GetExtent(e);
    for (int k = e[4]; k <= e[5]; ++k)
      for (int j = e[2]; j <= e[3]; ++j)
        for (int i = e[0]; i <= e[1]; ++i)
          either += truth->GetScalarComponentAsDouble(i, j, k, 0) == label;
    image->GetExtent(e);
    for (int k = e[4]; k <= e[5]; ++k)
      for (int j = e[2]; j <= e[3]; ++j)
        for (int i = e[0]; i <= e[1]; ++i) {
          if (image->GetScalarComponentAsDouble(i, j, k, 0) == 0) continue;
          double at[4] = {double(i), double(j), double(k), 1};
          toTruth->MultiplyPoint(at, at);
          both += truth->GetScalarComponentAsDouble(int(std::lround(at[0])), int(std::lround(at[1])),
                                                    int(std::lround(at[2])), 0) == label;
          ++either;
        }
    return 2 * both / either;
  }
  vtkMRMLInnerGSModelNode* model = nullptr;
  vtkSmartPointer<vtkOrientedImageData> truth;
};

TEST_F(SegmentQueryTest, LearnsAndFindsByWhatTheyAreCalled) {
  ASSERT_TRUE(logic->LearnSegments(model, node)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetModelNode(), model);
  EXPECT_TRUE(logic->GetLastJob()->GetLearning());
  EXPECT_EQ(model->GetModel()->GetNumberOfSegments(), 3);
  EXPECT_STREQ(model->GetAttribute("InnerGS.Segments"), "Organs");

  vtkNew<vtkTable> candidates;
  EXPECT_EQ(logic->FindByText(model, "kidney", candidates), vtkInnerGSSegment::Several);
  ASSERT_EQ(candidates->GetNumberOfRows(), 2);
  EXPECT_EQ(candidates->GetValueByName(1, "Name").ToString(), "kidney_right");
  EXPECT_EQ(candidates->GetValueByName(1, "Leading").ToInt(), 1);
  EXPECT_NE(logic->GetLastAnswer().find("say which"), std::string::npos) << logic->GetLastAnswer();

  auto* found = logic->SegmentByText(model, "hepar");
  ASSERT_NE(found, nullptr) << logic->GetLastError();
  EXPECT_EQ(found->GetSegmentation()->GetNumberOfSegments(), 1);
  EXPECT_GT(dice(found, "liver", 1), 0.9);
  std::string entry;
  EXPECT_TRUE(
      found->GetSegmentation()->GetNthSegment(0)->GetTag(vtkSegment::GetTerminologyEntryTagName(), entry));
  EXPECT_NE(entry.find("SCT^10200004^"), std::string::npos) << entry;
  EXPECT_STREQ(found->GetNodeReferenceID("InnerGSModel"), model->GetID());
  // More of them in the same node; one of the same name takes the place of the other.
  ASSERT_EQ(logic->SegmentByText(model, "kidney", found), found) << logic->GetLastError();
  ASSERT_EQ(logic->SegmentByText(model, "liver", found, 0.99, true, 10, 1), found);
  EXPECT_EQ(found->GetSegmentation()->GetNumberOfSegments(), 3);
  EXPECT_GT(dice(found, "kidney_left", 2), 0.85);
  EXPECT_GT(dice(found, "kidney_right", 3), 0.85);
  const double fine = dice(logic->SegmentByText(model, "liver", nullptr, 0, false, 0, 0, 1), "liver", 1);
  EXPECT_GT(fine, 0); // eight times the voxels: of another grid
}

TEST_F(SegmentQueryTest, SaysWhatIsNotThere) {
  const auto failing = [&](const std::string& text, const char* mention, int code) {
    errors.clear();
    EXPECT_EQ(logic->SegmentByText(model, text), nullptr);
    EXPECT_EQ(errors.size(), 1u);
    EXPECT_NE(logic->GetLastError().find(mention), std::string::npos) << logic->GetLastError();
    EXPECT_EQ(logic->GetLastErrorCode(), code);
  };
  failing("liver", "knows no segments", vtkInnerGSAlgorithm::NoDataError);
  ASSERT_TRUE(logic->LearnSegments(model, node)) << logic->GetLastError();
  const int nodes = scene->GetNumberOfNodes();
  failing("spleen", "not in this volume", vtkInnerGSAlgorithm::NoDataError);
  failing("bicycle", "matches no segment", vtkInnerGSAlgorithm::NoDataError);
  failing("liver mass", "matches no segment", vtkInnerGSAlgorithm::NoDataError);
  failing("", "empty", vtkInnerGSAlgorithm::InvalidArgumentError);
  failing(std::string(2000, 'x'), "2000 bytes", vtkInnerGSAlgorithm::InvalidArgumentError);
  EXPECT_EQ(scene->GetNumberOfNodes(), nodes);
  EXPECT_EQ(logic->FindByText(model, "spleen"), vtkInnerGSSegment::NotInVolume);
  EXPECT_EQ(logic->FindByText(nullptr, "spleen"), -1);
}

TEST_F(SegmentQueryTest, RefusesWhatCannotBeLearned) {
  const auto failing = [&](vtkMRMLNode* labels, const char* mention) {
    EXPECT_EQ(logic->StartLearning(model, labels), nullptr);
    EXPECT_NE(logic->GetLastError().find(mention), std::string::npos) << logic->GetLastError();
  };
  failing(nullptr, "choose a segmentation");
  failing(model, "neither a segmentation nor a labelmap");
  failing(scene->AddNewNodeByClass("vtkMRMLSegmentationNode", "Nothing"),
          "The segmentation 'Nothing' is empty");
  failing(input, "no colour table that names");
  segments->GetSegment("liver")->SetName("");
  failing(node, "has no name");
  segments->GetSegment("liver")->SetName("liver");
  vtkNew<vtkMatrix4x4> away;
  away->SetElement(0, 3, 500);
  node->SetAndObserveTransformNodeID(addTransform(away)->GetID());
  EXPECT_FALSE(logic->LearnSegments(model, node));
  EXPECT_FALSE(logic->GetLastError().empty());
  EXPECT_EQ(model->GetModel()->GetNumberOfSegments(), 0);
}

TEST_F(SegmentQueryTest, LearnsFromALabelMapWhereverTheModelWasMoved) {
  const double one[3] = {1, 1, 1}, origin[3] = {30, -20, 10};
  auto* transform = addTransform(oblique(25, one, origin));
  model->SetAndObserveTransformNodeID(transform->GetID());
  vtkNew<vtkMRMLColorTableNode> colors;
  colors->SetTypeToUser();
  colors->SetNumberOfColors(4);
  const char* const names[] = {"background", "liver", "spleen", "kidney_left"};
  for (int n = 0; n < 4; ++n)
    colors->SetColor(n, names[n], 0.2 * n, 0.5, 0.5);
  scene->AddNode(colors);
  vtkNew<vtkMRMLLabelMapVolumeDisplayNode> display;
  scene->AddNode(display);
  display->SetAndObserveColorNodeID(colors->GetID());
  vtkNew<vtkMRMLLabelMapVolumeNode> labels;
  labels->SetName("Labels");
  vtkNew<vtkImageData> voxels;
  voxels->ShallowCopy(truth);
  voxels->SetOrigin(0, 0, 0);
  voxels->SetSpacing(1, 1, 1);
  voxels->SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1);
  labels->SetAndObserveImageData(voxels);
  const auto matrix = matrixOf(input);
  labels->SetIJKToRASMatrix(matrix);
  scene->AddNode(labels);
  labels->SetAndObserveDisplayNodeID(display->GetID());
  labels->SetAndObserveTransformNodeID(transform->GetID());
  ASSERT_TRUE(logic->LearnSegments(model, labels)) << logic->GetLastError();
  auto* found = logic->SegmentByText(model, "spleen");
  ASSERT_NE(found, nullptr) << logic->GetLastError();
  EXPECT_EQ(found->GetParentTransformNode(), transform); // lies where the model lies
  EXPECT_GT(dice(found, "spleen", 2), 0.85);
  ASSERT_TRUE(model->HardenTransform());
  EXPECT_EQ(model->GetModel()->GetNumberOfSegments(), 3);
  auto* hardened = logic->SegmentByText(model, "spleen");
  ASSERT_NE(hardened, nullptr) << logic->GetLastError();
  const auto voxelsOf = [](vtkMRMLSegmentationNode* n) {
    auto* image = vtkOrientedImageData::SafeDownCast(
        n->GetSegmentation()->GetNthSegment(0)->GetRepresentation(kLabelmap));
    const auto* p = static_cast<const unsigned char*>(image->GetScalarPointer());
    return std::count(p, p + image->GetNumberOfPoints(), 1);
  };
  EXPECT_NEAR(double(voxelsOf(hardened)), double(voxelsOf(found)), 0.03 * double(voxelsOf(found)));
}

TEST_F(SegmentQueryTest, LearnsFromAFeatureVolumeWhereverTheModelWasMoved) {
  const double one[3] = {1, 1, 1}, origin[3] = {30, -20, 10};
  auto* transform = addTransform(oblique(25, one, origin));
  model->SetAndObserveTransformNodeID(transform->GetID());
  // Two numbers per voxel: the direction of each label's own.
  vtkNew<vtkImageData> voxels;
  voxels->SetDimensions(truth->GetDimensions());
  voxels->AllocateScalars(VTK_FLOAT, 2);
  const int* n = voxels->GetDimensions();
  int e[6];
  truth->GetExtent(e);
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const double angle = truth->GetScalarComponentAsDouble(e[0] + i, e[2] + j, e[4] + k, 0);
        voxels->SetScalarComponentFromDouble(i, j, k, 0, std::cos(angle));
        voxels->SetScalarComponentFromDouble(i, j, k, 1, std::sin(angle));
      }
  vtkNew<vtkMRMLVectorVolumeNode> features;
  features->SetName("Features");
  features->SetAndObserveImageData(voxels);
  const auto matrix = matrixOf(input);
  features->SetIJKToRASMatrix(matrix);
  scene->AddNode(features);
  features->SetAndObserveTransformNodeID(transform->GetID());
  const std::string texts = (folder / "texts.json").string();
  std::ofstream(texts)
      << R"({"background": [1, 0], "liver": [0.5403, 0.8415], "kidney_left": [-0.4161, 0.9093],
                             "kidney_right": [-0.98999, 0.1411]})";
  auto* job = logic->StartLearningFromFeatures(model, features, texts);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  logic->WaitForJob(job);
  ASSERT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
  EXPECT_STREQ(model->GetAttribute("InnerGS.Segments"), "Features");
  auto* found = logic->SegmentByText(model, "left kidney");
  ASSERT_NE(found, nullptr) << logic->GetLastError();
  EXPECT_GT(dice(found, "kidney_left", 2), 0.8);

  EXPECT_EQ(logic->StartLearningFromFeatures(model, nullptr, texts), nullptr);
  EXPECT_NE(logic->GetLastError().find("choose a feature volume"), std::string::npos);
  EXPECT_EQ(logic->StartLearningFromFeatures(model, features, (folder / "none.json").string()), nullptr);
  EXPECT_NE(logic->GetLastError().find("does not exist"), std::string::npos);
}

TEST_F(SegmentQueryTest, ANetworkThatIsNoneIsOneSentence) {
  vtkNew<vtkStringArray> names;
  names->InsertNextValue("liver");
  const std::string file = (folder / "foreign.onnx").string();
  std::ofstream(file) << "not a network";
  for (const std::string& network : {file, (folder / "none.onnx").string()}) {
    auto* job = logic->StartLearningFromNetwork(model, network, names);
    ASSERT_NE(job, nullptr) << logic->GetLastError();
    logic->WaitForJob(job);
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
    EXPECT_FALSE(job->GetErrorMessage().empty());
    EXPECT_EQ(job->GetErrorMessage().find('\n'), std::string::npos);
  }
  EXPECT_EQ(model->GetModel()->GetNumberOfSegments(), 0);
}

TEST_F(SegmentQueryTest, LabelsForAThreadOfAPanel) {
  const auto later = logic->LabelsLater(model, node);
  ASSERT_TRUE(later) << logic->GetLastError();
  innergs::NamedLabels given;
  std::thread([&] { given = later({}); }).join();
  ASSERT_EQ(given.names.size(), 3u);
  EXPECT_EQ(given.names[1].name, "kidney_left");
  const auto count = [&](int label) {
    return std::count(given.labels.voxels.begin(), given.labels.voxels.end(), label);
  };
  EXPECT_GT(count(1), count(3));
  EXPECT_GT(count(3), 0);
  EXPECT_FALSE(logic->LabelsLater(model, nullptr));
  EXPECT_NE(logic->GetLastError().find("choose a segmentation"), std::string::npos);
}

TEST_F(SegmentQueryTest, TheScoreIsAVolumeUnderTheModelsTransform) {
  EXPECT_EQ(logic->ScoreByText(model, "liver"), nullptr);
  EXPECT_NE(logic->GetLastError().find("knows no segments"), std::string::npos);
  ASSERT_TRUE(logic->LearnSegments(model, node)) << logic->GetLastError();
  auto* score = logic->ScoreByText(model, "liver");
  ASSERT_NE(score, nullptr) << logic->GetLastError();
  EXPECT_STREQ(score->GetNodeReferenceID("InnerGSModel"), model->GetID());
  EXPECT_EQ(score->GetParentTransformNode(), model->GetParentTransformNode());
  double range[2];
  score->GetImageData()->GetScalarRange(range);
  EXPECT_EQ(range[0], 0);
  EXPECT_GT(range[1], 0.9);
  EXPECT_LE(range[1], 1);
  EXPECT_EQ(logic->ScoreByText(model, "left kidney", score, 2), score);
  EXPECT_EQ(logic->ScoreByText(model, "spleen"), nullptr);
  EXPECT_NE(logic->GetLastError().find("not in this volume"), std::string::npos);
}

TEST_F(SegmentQueryTest, SparseSlicesFollowTheScan) {
  int e[6];
  truth->GetExtent(e);
  for (int k = e[4]; k <= e[5]; ++k)
    for (int j = e[2]; j <= e[3] && k % 3 != 0; ++j)
      for (int i = e[0]; i <= e[1]; ++i)
        truth->SetScalarComponentFromDouble(i, j, k, 0, 0);
  truth->Modified();
  ASSERT_TRUE(logic->LearnSegments(model, node, true)) << logic->GetLastError();
  auto* sparse = logic->SegmentByText(model, "liver");
  ASSERT_NE(sparse, nullptr) << logic->GetLastError();
  auto* image = vtkOrientedImageData::SafeDownCast(
      sparse->GetSegmentation()->GetNthSegment(0)->GetRepresentation(kLabelmap));
  int extent[6];
  image->GetExtent(extent);
  const auto inside = [&](int k) {
    int count = 0;
    for (int j = extent[2]; j <= extent[3]; ++j)
      for (int i = extent[0]; i <= extent[1]; ++i)
        count += image->GetScalarComponentAsDouble(i, j, k, 0) != 0;
    return count;
  };
  ASSERT_LE(extent[4], 6);
  ASSERT_GE(extent[5], 9);
  EXPECT_GT(inside(7), 0); // between the labelled 6 and 9
  EXPECT_GT(inside(8), 0);
}

TEST_F(SegmentQueryTest, KeptInTheModelsFile) {
  ASSERT_TRUE(logic->LearnSegments(model, node)) << logic->GetLastError();
  EXPECT_TRUE(model->GetModifiedSinceRead());
  const std::string file = (folder / "named.innergs").string();
  ASSERT_TRUE(logic->SaveModel(model, file)) << logic->GetLastError();
  EXPECT_FALSE(model->GetModifiedSinceRead());
  auto* loaded = logic->LoadModel(file);
  ASSERT_NE(loaded, nullptr) << logic->GetLastError();
  ASSERT_EQ(loaded->GetModel()->GetNumberOfSegments(), 3);
  EXPECT_STREQ(loaded->GetAttribute("InnerGS.Segments"), "Organs");
  EXPECT_GT(dice(logic->SegmentByText(loaded, "liver"), "liver", 1), 0.9);
  // What a PLY file leaves out does not count as saved.
  vtkMRMLStorageNode* storage = loaded->GetStorageNode();
  storage->SetFileName((folder / "named.ply").string().c_str());
  ASSERT_TRUE(storage->WriteData(loaded));
  EXPECT_TRUE(loaded->GetModifiedSinceRead());
  // Learned again: not what the file holds.
  ASSERT_TRUE(logic->LearnSegments(model, node)) << logic->GetLastError();
  EXPECT_TRUE(model->GetModifiedSinceRead());
}

TEST_F(SegmentQueryTest, CancelAndChangesMeanwhile) {
  const auto before = model->GetModel()->GetCoreModel();
  auto* job = logic->StartLearning(model, node);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  logic->Cancel(job);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(model->GetModel()->GetNumberOfSegments(), 0);
  // Another model in the node: what was learned is of no use.
  job = logic->StartLearning(model, node);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  vtkNew<vtkInnerGSModel> other;
  other->SetCoreModel(std::make_shared<innergs::Model>(*before));
  model->SetModel(other);
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_NE(job->GetErrorMessage().find("was replaced"), std::string::npos) << job->GetErrorMessage();
  // A removed one: nothing to tell.
  job = logic->StartLearning(model, node);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  scene->RemoveNode(model);
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
}

} // namespace
