#include "Fixtures.h"

#include "Features/BoxPhantom.h"
#include "vtkInnerGSLearnSegments.h"
#include "vtkInnerGSSegment.h"

#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>

using namespace innergs;
using namespace innergs::testing;

namespace {

class Segments : public ::testing::Test {
protected:
  BoxPhantom phantom;
  vtkSmartPointer<vtkInnerGSModel> model = modelOf(phantom.field);

  vtkSmartPointer<vtkImageData> labelImage(int type = VTK_UNSIGNED_CHAR) const {
    Volume volume{phantom.labels.geometry, {}};
    volume.voxels.assign(phantom.labels.voxels.begin(), phantom.labels.voxels.end());
    return plainImage(volume, type);
  }
  vtkSmartPointer<vtkInnerGSLearnSegments> learning() const {
    auto learn = vtkSmartPointer<vtkInnerGSLearnSegments>::New();
    learn->SetModel(model);
    learn->SetLabels(labelImage(), rasMatrix(phantom.labels.geometry));
    learn->SetSegmentName(1, "liver");
    learn->SetSegmentName(2, "kidney_left");
    learn->SetSegmentName(3, "kidney_right");
    return learn;
  }
  vtkSmartPointer<vtkInnerGSSegment> segmenting() const {
    auto learn = learning();
    learn->Update();
    EXPECT_EQ(learn->GetErrorMessage(), "");
    auto filter = vtkSmartPointer<vtkInnerGSSegment>::New();
    filter->SetModel(learn->GetOutput());
    return filter;
  }
  static std::vector<int> labelsOf(vtkInnerGSSegment* filter) {
    vtkDataArray* scalars = filter->GetOutput()->GetPointData()->GetScalars();
    std::vector<int> labels;
    for (vtkIdType n = 0; scalars && n < scalars->GetNumberOfTuples(); ++n)
      labels.push_back(static_cast<int>(scalars->GetTuple1(n)));
    return labels;
  }
};

TEST_F(Segments, AreFoundByWhatTheyAreCalled) {
  auto filter = segmenting();
  ASSERT_EQ(filter->GetModel()->GetNumberOfSegments(), 3);
  EXPECT_EQ(filter->GetModel()->GetSegmentName(1), "kidney_left");
  EXPECT_NE(filter->GetModel()->GetDescription().find("3 named segments"), std::string::npos);
  filter->AddQuery("hepar");
  filter->AddQuery("right kindey");
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  EXPECT_EQ(filter->GetOutput()->GetScalarType(), VTK_UNSIGNED_CHAR);
  EXPECT_TRUE(closeTo(filter->GetOutputIJKToRASMatrix(), rasMatrix(phantom.labels.geometry)));
  const std::vector<int> found = labelsOf(filter);
  ASSERT_EQ(found.size(), phantom.labels.voxels.size());
  for (std::size_t v = 0; v < found.size(); ++v) {
    const int truth = phantom.labels.voxels[v];
    ASSERT_EQ(found[v], truth == 1 ? 1 : truth == 3 ? 2 : 0) << v;
  }
  ASSERT_EQ(filter->GetNumberOfSegments(), 2);
  EXPECT_EQ(filter->GetSegmentName(0), "liver");
  EXPECT_EQ(filter->GetSegmentCode(0), "10200004");
  EXPECT_EQ(filter->GetSegmentSide(1), "right");
  EXPECT_EQ(filter->GetSegmentVolume(0),
            8.0 * static_cast<double>(std::count(found.begin(), found.end(), 1)));
  EXPECT_EQ(filter->GetAnswer(0), vtkInnerGSSegment::Found);
  EXPECT_EQ(filter->GetCandidateName(1, 0), "kidney_right");
  EXPECT_LT(filter->GetCandidateScore(1, 0), 1); // a typing error
  double color[3] = {-1, -1, -1};
  filter->GetSegmentColor(0, color);
  EXPECT_GE(*std::min_element(color, color + 3), 0);
}

TEST_F(Segments, SayWhatIsNotThere) {
  auto filter = segmenting();
  for (const char* query : {"kidney", "spleen", "bicycle"})
    filter->AddQuery(query);
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  EXPECT_EQ(filter->GetAnswer(0), vtkInnerGSSegment::Several);
  EXPECT_EQ(filter->GetNumberOfLeadingCandidates(0), 2);
  EXPECT_EQ(filter->GetAnswer(1), vtkInnerGSSegment::NotInVolume);
  EXPECT_EQ(filter->GetAnswer(2), vtkInnerGSSegment::NoMatch);
  EXPECT_NE(filter->GetAnswerText(1).find("not in this volume"), std::string::npos);
  EXPECT_EQ(filter->GetNumberOfSegments(), 2); // both sides
  EXPECT_EQ(filter->GetAnswerText(7), "");
  EXPECT_EQ(filter->GetSegmentName(-1), "");
}

TEST_F(Segments, OnAnyGridWithOptions) {
  auto filter = segmenting();
  filter->SetQuery("liver");
  filter->SetOutputSpacing(1, 1, 1);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetDimensions()[0], 28);
  const double volume = filter->GetSegmentVolume(0);
  EXPECT_NEAR(
      volume,
      8.0 * static_cast<double>(std::count(phantom.labels.voxels.begin(), phantom.labels.voxels.end(), 1)),
      0.15 * volume);
  filter->SetThreshold(0.95);
  filter->Update();
  EXPECT_LT(filter->GetSegmentVolume(0), volume);
  filter->SetThreshold(0);
  filter->SetMinimumSize(2 * volume);
  filter->Update();
  EXPECT_EQ(filter->GetSegmentVolume(0), 0);
  filter->SetMinimumSize(0);
  const GridGeometry part = cropped(phantom.labels.geometry, {0, 0, 4}, {14, 14, 1});
  filter->SetReferenceGrid(rasMatrix(part), 14, 14, 1);
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  const auto plane = labelsOf(filter);
  ASSERT_EQ(plane.size(), 14u * 14u);
  for (std::size_t v = 0; v < plane.size(); ++v)
    EXPECT_EQ(plane[v], phantom.labels.voxels[v + 4 * 14 * 14] == 1);
}

TEST_F(Segments, BadInputIsOneSentence) {
  vtkNew<vtkInnerGSSegment> filter;
  Errors errors(filter);
  const auto failing = [&](const char* mention, int code) {
    errors.texts.clear();
    filter->Modified();
    filter->Update();
    ASSERT_EQ(errors.texts.size(), 1u) << mention;
    EXPECT_NE(filter->GetErrorMessage().find(mention), std::string::npos) << filter->GetErrorMessage();
    EXPECT_EQ(filter->GetErrorCode(), static_cast<unsigned long>(code));
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  };
  filter->SetQuery("liver");
  failing("no model", vtkInnerGSAlgorithm::NoDataError);
  filter->SetModel(model);
  failing("knows no segments", vtkInnerGSAlgorithm::NoDataError);
  filter->SetModel(segmenting()->GetModel());
  filter->RemoveAllQueries();
  failing("no query", vtkInnerGSAlgorithm::InvalidArgumentError);
  filter->SetQuery("  ");
  failing("empty", vtkInnerGSAlgorithm::InvalidArgumentError);
  filter->SetQuery(std::string(2000, 'x'));
  failing("2000 bytes", vtkInnerGSAlgorithm::InvalidArgumentError);
  filter->SetQuery("liver");
  filter->SetThreshold(2);
  failing("threshold", vtkInnerGSAlgorithm::InvalidArgumentError);
}

TEST_F(Segments, LearningRefusesWhatIsNoLabelmap) {
  auto learn = learning();
  Errors errors(learn);
  const auto failing = [&](const char* mention) {
    errors.texts.clear();
    learn->Update();
    ASSERT_EQ(errors.texts.size(), 1u) << mention;
    EXPECT_NE(errors.texts[0].find(mention), std::string::npos) << errors.texts[0];
    EXPECT_TRUE(learn->GetOutput()->IsEmpty());
  };
  learn->RemoveAllSegmentNames();
  failing("no names");
  learn->SetSegmentName(70000, "liver");
  failing("1 to 65535");
  learn->SetSegmentName(70000, "");
  learn->SetSegmentName(1, "liver");
  GridGeometry away = phantom.labels.geometry;
  away.origin[0] += 900;
  learn->SetLabels(labelImage(), rasMatrix(away));
  failing("same patient");
  learn->SetLabels(nullptr);
  failing("no labels");
  Volume noise{phantom.labels.geometry, std::vector<float>(phantom.labels.voxels.size(), 0.5f)};
  learn->SetLabels(plainImage(noise), rasMatrix(phantom.labels.geometry));
  failing("labelmap");
}

TEST_F(Segments, LearningCanBeStoppedAndSparseSlicesAreFollowed) {
  auto learn = learning();
  int events = 0;
  {
    Observer progress(learn, vtkCommand::ProgressEvent, [&](void*) {
      if (++events == 3) learn->SetAbortExecute(1);
    });
    learn->Update();
  }
  EXPECT_TRUE(learn->GetAborted());
  EXPECT_TRUE(learn->GetOutput()->IsEmpty());
  EXPECT_EQ(learn->GetErrorMessage(), "");

  const Labelmap sparse = phantom.every(3);
  Volume volume{phantom.labels.geometry, {}};
  volume.voxels.assign(sparse.voxels.begin(), sparse.voxels.end());
  learn->SetLabels(plainImage(volume), rasMatrix(phantom.labels.geometry));
  learn->SparseSlicesOn();
  learn->Update();
  ASSERT_EQ(learn->GetErrorMessage(), "");
  vtkNew<vtkInnerGSSegment> filter;
  filter->SetModel(learn->GetOutput());
  filter->SetQuery("left kidney");
  filter->Update();
  const auto found = labelsOf(filter);
  int wrong = 0, right = 0;
  for (std::size_t v = 0; v < found.size(); ++v) {
    wrong += (found[v] == 1) != (phantom.labels.voxels[v] == 2);
    right += found[v] == 1 && phantom.labels.voxels[v] == 2;
  }
  EXPECT_LT(wrong, 0.2 * right);
}

TEST_F(Segments, TheScoreIsTheProbabilityOnTheSameGrid) {
  auto filter = segmenting();
  filter->SetQuery("liver");
  filter->Update();
  EXPECT_EQ(filter->GetScore()->GetNumberOfPoints(), 0);
  filter->MakeScoreOn();
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  vtkDataArray* score = filter->GetScore()->GetPointData()->GetScalars();
  const std::vector<int> found = labelsOf(filter);
  ASSERT_EQ(score->GetNumberOfTuples(), static_cast<vtkIdType>(found.size()));
  for (std::size_t v = 0; v < found.size(); ++v) {
    const double probability = score->GetTuple1(static_cast<vtkIdType>(v));
    ASSERT_TRUE(probability >= 0 && probability <= 1);
    ASSERT_EQ(found[v] == 1, probability > 0.5) << v;
  }
}

TEST_F(Segments, LearnFromAFeatureVolumeAndTexts) {
  auto learn = learning();
  learn->SetLabels(nullptr);
  vtkNew<vtkImageData> features;
  const auto& size = phantom.labels.geometry.size;
  features->SetDimensions(static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2]));
  features->AllocateScalars(VTK_DOUBLE, 2);
  vtkDataArray* values = features->GetPointData()->GetScalars();
  const auto angleOf = [](int label) { return 0.9 * label; };
  for (std::size_t v = 0; v < phantom.labels.voxels.size(); ++v)
    values->SetTuple2(static_cast<vtkIdType>(v), std::cos(angleOf(phantom.labels.voxels[v])),
                      std::sin(angleOf(phantom.labels.voxels[v])));
  learn->SetFeatures(features, rasMatrix(phantom.labels.geometry));
  const char* const texts[] = {"background", "liver", "kidney_left", "kidney_right"};
  for (int label = 0; label < 4; ++label) {
    vtkNew<vtkDoubleArray> text;
    text->InsertNextValue(std::cos(angleOf(label)));
    text->InsertNextValue(std::sin(angleOf(label)));
    learn->SetTextEmbedding(texts[label], text);
  }
  EXPECT_EQ(learn->GetNumberOfTextEmbeddings(), 4);
  learn->Update();
  ASSERT_EQ(learn->GetErrorMessage(), "");
  vtkNew<vtkInnerGSSegment> filter;
  filter->SetModel(learn->GetOutput());
  filter->SetQuery("left kidney");
  filter->Update();
  const std::vector<int> found = labelsOf(filter);
  int wrong = 0, right = 0;
  for (std::size_t v = 0; v < found.size(); ++v) {
    wrong += (found[v] == 1) != (phantom.labels.voxels[v] == 2);
    right += found[v] == 1 && phantom.labels.voxels[v] == 2;
  }
  EXPECT_LT(wrong, 0.2 * right);

  Errors errors(learn);
  const auto failing = [&](const char* mention) {
    errors.texts.clear();
    learn->Update();
    ASSERT_EQ(errors.texts.size(), 1u) << mention;
    EXPECT_NE(errors.texts[0].find(mention), std::string::npos) << errors.texts[0];
  };
  learn->SetNetworkFile("nowhere.onnx");
  failing("several teachers");
  learn->SetFeatures(nullptr);
  failing("no network 'nowhere.onnx'");
  learn->SetNetworkFile("");
  failing("no labels");
}

} // namespace
