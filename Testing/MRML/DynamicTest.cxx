#include "Core/Features/FeatureTraining.h"
#include "Core/Motion/DynamicFeatures.h"
#include "Core/Motion/DynamicField.h"
#include "IO/RecoveredFit.h"
#include "JobFixture.h"

#include "vtkInnerGSDynamicModel.h"
#include "vtkSlicerInnerGSDynamicRequest.h"

#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLStorageNode.h>
#include <vtkMRMLTableNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkDoubleArray.h>
#include <vtkGeneralTransform.h>
#include <vtkOrientedImageData.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>

#include <fstream>

namespace {

/// A scene with a dynamic scan: a blob on a ground, 1.2 mm along R per frame of 0.25 s, on an oblique grid.
class DynamicTest : public JobTest {
protected:
  static constexpr double step = 1.2; // mm per frame

  static double blob(double r, double a, double s, double frame) {
    const double d = r + 4 - step * frame;
    return 30 + 400 * std::exp(-(d * d + a * a + s * s) / 30);
  }

  vtkMRMLSequenceNode* addSeries(int frames, const char* unit = "s") {
    auto* sequence = addNode<vtkMRMLSequenceNode>("Wrist");
    sequence->SetIndexName(*unit ? "time" : "frame");
    sequence->SetIndexUnit(unit);
    const double spacing[3] = {2, 2, 3}, origin[3] = {-17, -14, -12};
    const int size[3] = {18, 16, 9};
    const auto ijkToRAS = oblique(12, spacing, origin);
    for (int f = 0; f < frames; ++f) {
      vtkNew<vtkMRMLScalarVolumeNode> volume;
      vtkNew<vtkImageData> image;
      image->SetDimensions(size);
      image->AllocateScalars(VTK_SHORT, 1);
      for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
          for (int i = 0; i < size[0]; ++i) {
            const double index[4] = {double(i), double(j), double(k), 1};
            double ras[4];
            ijkToRAS->MultiplyPoint(index, ras);
            image->SetScalarComponentFromDouble(i, j, k, 0, std::round(blob(ras[0], ras[1], ras[2], f)));
          }
      volume->SetIJKToRASMatrix(ijkToRAS);
      volume->SetAndObserveImageData(image);
      sequence->SetDataNodeAtValue(volume, std::to_string(0.25 * f));
    }
    return sequence;
  }
  vtkSmartPointer<vtkSlicerInnerGSDynamicRequest> requestFor(vtkMRMLSequenceNode* series) {
    auto request = vtkSmartPointer<vtkSlicerInnerGSDynamicRequest>::New();
    request->SetSeries(series);
    request->SetKind(vtkSlicerInnerGSDynamicRequest::Motion);
    return request;
  }
  static bool isInside(const double ras[3], double frame) {
    return blob(ras[0], ras[1], ras[2], frame) > 230;
  }
  /// The Dice coefficient of a node's only segment with the blob at a time.
  static double diceOf(vtkMRMLSegmentationNode* node, double seconds) {
    const char* binary = vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName();
    auto* image = vtkOrientedImageData::SafeDownCast(
        node->GetSegmentation()->GetNthSegment(0)->GetRepresentation(binary));
    vtkNew<vtkMatrix4x4> toWorld;
    image->GetImageToWorldMatrix(toWorld);
    int e[6];
    image->GetExtent(e);
    const int margin = 10; // of voxels, for what the segment misses
    double both = 0, sum = 0;
    for (int k = e[4] - margin; k <= e[5] + margin; ++k)
      for (int j = e[2] - margin; j <= e[3] + margin; ++j)
        for (int i = e[0] - margin; i <= e[1] + margin; ++i) {
          double at[4] = {double(i), double(j), double(k), 1};
          toWorld->MultiplyPoint(at, at);
          const bool truth = isInside(at, seconds / 0.25);
          const bool found = i >= e[0] && i <= e[1] && j >= e[2] && j <= e[3] && k >= e[4] && k <= e[5] &&
                             image->GetScalarComponentAsDouble(i, j, k, 0) != 0;
          both += truth && found;
          sum += truth + found;
        }
    return 2 * both / sum;
  }
  std::string refusal(vtkSlicerInnerGSDynamicRequest* request) {
    EXPECT_EQ(logic->StartDynamicReconstruction(request), nullptr);
    return logic->GetLastError();
  }
};

TEST_F(DynamicTest, SequenceInModelAndFramesOut) {
  auto* series = addSeries(9);
  const auto request = requestFor(series);
  request->SetRate(8);
  EXPECT_EQ(logic->CheckDynamicRequest(request), "");
  double last = 0;
  bool judged = false;
  Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
    EXPECT_GE(jobOf(data)->GetProgress(), last);
    last = jobOf(data)->GetProgress();
    judged = judged || jobOf(data)->IsJudging();
  });
  ASSERT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
  EXPECT_TRUE(judged);
  vtkSlicerInnerGSJob* job = logic->GetLastJob();
  vtkMRMLSequenceNode* frames = job->GetSequenceNode();
  ASSERT_NE(frames, nullptr);
  EXPECT_EQ(frames->GetNumberOfDataNodes(), 17); // 2 s
  EXPECT_EQ(frames->GetIndexUnit(), "s");
  EXPECT_EQ(frames->GetNthIndexValue(3), "0.375");
  ASSERT_NE(job->GetBrowserNode(), nullptr);
  EXPECT_EQ(job->GetBrowserNode()->GetMasterSequenceNode(), frames);
  ASSERT_NE(job->GetTableNode(), nullptr);
  EXPECT_NE(std::string(job->GetTableNode()->GetAttribute("InnerGS.Samples")).find("no method saw"),
            std::string::npos);

  // Values between frames, in the world.
  vtkMRMLInnerGSModelNode* model = job->GetModelNode();
  ASSERT_TRUE(model && model->IsDynamic());
  int changes = 0;
  Observer changed(model, {vtkMRMLInnerGSModelNode::ModelModifiedEvent},
                   [&](unsigned long, void*) { ++changes; });
  model->SetTime(1.125); // between frames 4 and 5
  EXPECT_EQ(changes, 1);
  EXPECT_NEAR(logic->GetValueAtRAS(model, -4 + 4.5 * step, 0, 0), blob(-4 + 4.5 * step, 0, 0, 4.5), 25);
  EXPECT_NEAR(logic->GetValueAtRAS(model, -4 + 8 * step, 0, 0), blob(-4 + 8 * step, 0, 0, 4.5), 25);
  vtkNew<vtkMatrix4x4> plane;
  ASSERT_NE(logic->QueryPlane(model, plane, 16, 16, 1), nullptr);
  // The frame of the sequence at that time is what the model shows.
  auto* frame = vtkMRMLScalarVolumeNode::SafeDownCast(frames->GetDataNodeAtValue("1.125"));
  ASSERT_NE(frame, nullptr);
  vtkMRMLScalarVolumeNode* now = logic->Resample(model);
  ASSERT_NE(now, nullptr);
  for (vtkIdType v = 0; v < now->GetImageData()->GetNumberOfPoints(); ++v)
    ASSERT_NEAR(now->GetImageData()->GetPointData()->GetScalars()->GetTuple1(v),
                frame->GetImageData()->GetPointData()->GetScalars()->GetTuple1(v), 1e-2);
  model->SetTime(99);
  EXPECT_EQ(model->GetTime(), 2);

  // Saved, read, and at the same time in a scene's file.
  const std::string file = (folder / "moving.innergs").string();
  ASSERT_TRUE(logic->SaveModel(model, file)) << logic->GetLastError();
  EXPECT_FALSE(model->GetModifiedSinceRead());
  model->SetTime(0.5);
  EXPECT_FALSE(model->GetModifiedSinceRead()); // another time is no change
  vtkMRMLInnerGSModelNode* read = logic->LoadModel(file);
  ASSERT_TRUE(read && read->IsDynamic());
  EXPECT_EQ(read->GetDynamicModel()->GetNumberOfFrames(), 9);
  read->SetTime(0.5);
  EXPECT_EQ(logic->GetValueAtRAS(read, 1, 2, 3), logic->GetValueAtRAS(model, 1, 2, 3));

  // The file keeps the segments that the model knows.
  const auto field = model->GetDynamicModel()->GetField();
  innergs::Volume labels{field->canonical.region(), {}};
  labels.voxels.assign(static_cast<std::size_t>(labels.geometry.voxelCount()), 0);
  std::fill_n(labels.voxels.begin(), labels.voxels.size() / 2, 1.f);
  const auto learned = std::make_shared<const innergs::FeatureModel>(
      innergs::trainFeatures(field->canonical, innergs::labelmapOf(labels), {{1, "lunate"}}));
  vtkNew<vtkInnerGSDynamicModel> labelled;
  labelled->SetField(field, learned);
  model->SetDynamicModel(labelled);
  EXPECT_TRUE(model->GetModifiedSinceRead());
  ASSERT_TRUE(logic->SaveModel(model, file)) << logic->GetLastError();
  EXPECT_FALSE(model->GetModifiedSinceRead());
  vtkMRMLInnerGSModelNode* again = logic->LoadModel(file);
  ASSERT_TRUE(again && again->GetDynamicModel()->GetFeatures());
  EXPECT_EQ(again->GetDynamicModel()->GetSegmentName(0), "lunate");
  EXPECT_EQ(again->GetDynamicModel()->GetFeatures()->latents, learned->latents);

  // Motion: a point at `from` moves with the blob, and a frame's transform brings it back.
  vtkMRMLSequenceNode* motion = logic->CreateMotion(model, nullptr, 0.5);
  ASSERT_NE(motion, nullptr) << logic->GetLastError();
  auto* transform = vtkMRMLTransformNode::SafeDownCast(motion->GetDataNodeAtValue("1.5"));
  ASSERT_NE(transform, nullptr);
  double at[3] = {-4 + 2 * step, 0, 0}, moved[3];
  transform->GetTransformFromParent()->TransformPoint(at, moved);
  EXPECT_NEAR(moved[0], -4 + 6 * step, 0.8);
  EXPECT_NEAR(moved[1], 0, 0.5);

  vtkNew<vtkDoubleArray> times;
  times->InsertNextValue(0.1);
  times->InsertNextValue(0.2);
  vtkMRMLSequenceNode* some = logic->CreateFrames(model, times);
  ASSERT_NE(some, nullptr);
  EXPECT_EQ(some->GetNthIndexValue(1), "0.2");
}

TEST_F(DynamicTest, SegmentsAreThoseOfTheNodesTime) {
  const auto request = requestFor(addSeries(9));
  request->EvaluateQualityOff();
  ASSERT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
  vtkMRMLInnerGSModelNode* model = logic->GetLastJob()->GetModelNode();
  const auto field = model->GetDynamicModel()->GetField();
  const double learned = 0.5;
  innergs::Volume labels;
  labels.geometry.size = {29, 25, 21};
  labels.geometry.origin = {-14, -12, -10};
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 25; ++j)
      for (int i = 0; i < 29; ++i) {
        const double ras[3] = {14.0 - i, 12.0 - j, k - 10.0};
        labels.voxels.push_back(isInside(ras, learned / 0.25) ? 1.f : 0.f);
      }
  innergs::FeatureModel features = innergs::trainFeatures(innergs::featureFieldAt(*field, learned),
                                                          innergs::labelmapOf(labels), {{1, "lunate"}});
  features.time = learned;
  vtkNew<vtkInnerGSDynamicModel> labelled;
  labelled->SetField(field, std::make_shared<const innergs::FeatureModel>(features));
  model->SetDynamicModel(labelled);

  vtkMRMLSegmentationNode* segments = nullptr;
  for (const double seconds : {1.625, 0.5, 1.1}) {
    model->SetTime(seconds);
    EXPECT_EQ(logic->FindByText(model, "the lunate"), 0) << logic->GetLastAnswer();
    segments = logic->SegmentByText(model, "lunate", segments, 0, false, 0, 0, 1);
    ASSERT_NE(segments, nullptr) << logic->GetLastError();
    EXPECT_EQ(segments->GetSegmentation()->GetNumberOfSegments(), 1);
    EXPECT_GT(diceOf(segments, seconds), 0.9) << seconds;
    if (seconds != learned) {
      EXPECT_LT(diceOf(segments, learned), 0.8) << seconds;
    }
  }
  vtkMRMLScalarVolumeNode* score = logic->ScoreByText(model, "lunate");
  ASSERT_NE(score, nullptr) << logic->GetLastError();
  EXPECT_EQ(score->GetImageData()->GetScalarType(), VTK_FLOAT);
}

TEST_F(DynamicTest, FramesAtTheSeriesTimesShareItsBrowser) {
  auto* series = addSeries(5);
  auto* browser = addNode<vtkMRMLSequenceBrowserNode>("Browser");
  browser->SetAndObserveMasterSequenceNodeID(series->GetID());
  const auto request = requestFor(series);
  request->EvaluateQualityOff();
  ASSERT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
  EXPECT_EQ(logic->GetLastJob()->GetBrowserNode(), browser);
  EXPECT_EQ(logic->GetLastJob()->GetTableNode(), nullptr);
}

TEST_F(DynamicTest, CancelEndsIt) {
  vtkSlicerInnerGSJob* job = logic->StartDynamicReconstruction(requestFor(addSeries(9)));
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  waitUntil([&] { return logic->IsRunning() && job->GetState() == vtkSlicerInnerGSJob::Running; });
  logic->Cancel(job);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  EXPECT_EQ(job->GetRecoveryFile(), "");
}

/// By events: the model so far is shown at a time, then the job is cancelled and goes on from its file.
TEST_F(DynamicTest, APreviewIsShownAndACancelledFitGoesOn) {
  auto* series = addSeries(9);
  const auto whole = [&](vtkSlicerInnerGSDynamicRequest* request) {
    EXPECT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
    return logic->GetLastJob()->GetModelNode()->GetDynamicModel()->GetField();
  };
  const auto request = requestFor(series);
  request->EvaluateQualityOff();
  request->SetSetting("rounds", "150");
  EXPECT_EQ(logic->PreviewFrame(nullptr, 0), nullptr);
  EXPECT_NE(logic->GetLastError().find("no preview"), std::string::npos);
  const auto uninterrupted = whole(request);

  request->KeepWhenCancelledOn();
  vtkMRMLScalarVolumeNode* shown = nullptr;
  const auto stopAtPreview = [&] {
    vtkSmartPointer<vtkSlicerInnerGSJob> job;
    Observer watch(logic, {Logic::JobPreviewEvent}, [&](unsigned long, void* data) {
      if (!shown) shown = logic->PreviewFrame(jobOf(data), 1.125);
      logic->RequestCancel(jobOf(data));
    });
    job = logic->StartDynamicReconstruction(request);
    EXPECT_NE(job, nullptr) << logic->GetLastError();
    logic->WaitForJob(job);
    return job;
  };
  const auto job = stopAtPreview();
  ASSERT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(job->GetPreviewModel(), nullptr);
  ASSERT_NE(shown, nullptr);
  // Where the blob is half-way between frames 4 and 5, in the world.
  vtkNew<vtkMatrix4x4> toIJK;
  shown->GetRASToIJKMatrix(toIJK);
  const double ras[4] = {-4 + 4.5 * step, 0, 0, 1};
  double ijk[4];
  toIJK->MultiplyPoint(ras, ijk);
  EXPECT_NEAR(shown->GetImageData()->GetScalarComponentAsDouble(
                  int(std::lround(ijk[0])), int(std::lround(ijk[1])), int(std::lround(ijk[2])), 0),
              430, 90);
  const std::string file = job->GetRecoveryFile();
  ASSERT_TRUE(std::filesystem::exists(file));
  const auto kept = innergs::recoveredFits(logic->GetRecoveryFolder());
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(kept[0].dynamic);
  EXPECT_EQ(kept[0].inputs, "Wrist");
  EXPECT_EQ(kept[0].iterations, 150 * 9);
  EXPECT_LT(kept[0].iteration, kept[0].iterations);

  // Of another scan or other settings it is refused, and stays.
  request->SetResumeFileName(file);
  request->SetSetting("rounds", "151");
  EXPECT_FALSE(logic->ReconstructDynamic(request));
  EXPECT_NE(logic->GetLastError().find("other settings"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(file));
  request->SetSetting("rounds", "150");
  const auto resumed = whole(request);
  EXPECT_EQ(resumed->nodes, uninterrupted->nodes);
  EXPECT_EQ(resumed->ownPath, uninterrupted->ownPath);
  EXPECT_TRUE(innergs::recoveredFits(logic->GetRecoveryFolder()).empty());
  request->SetResumeFileName((folder / "gone.innergs").string());
  EXPECT_NE(refusal(request).find("does not exist"), std::string::npos);
}

TEST_F(DynamicTest, ClosingTheSceneKeepsWhereItStood) {
  const auto request = requestFor(addSeries(9));
  request->SetSetting("rounds", "10000"); // until the scene is closed
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartDynamicReconstruction(request);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  waitUntil([&] {
    logic->ProcessPendingEvents();
    return job->IsDone() || job->GetPreviewModel();
  });
  std::vector<std::string> warnings;
  Observer onWarning(logic, {vtkCommand::WarningEvent},
                     [&](unsigned long, void* text) { warnings.emplace_back(static_cast<char*>(text)); });
  scene->Clear(false);
  ASSERT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  ASSERT_TRUE(std::filesystem::exists(job->GetRecoveryFile()));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find(job->GetRecoveryFile()), std::string::npos);
}

/// Its quality need not be judged for it to be whole.
TEST_F(DynamicTest, ClosingTheSceneWhileItIsJudgedKeepsAllOfIt) {
  const vtkSmartPointer<vtkSlicerInnerGSJob> job =
      logic->StartDynamicReconstruction(requestFor(addSeries(9)));
  waitUntil([&] {
    logic->ProcessPendingEvents();
    return job->IsDone() || job->IsJudging();
  });
  scene->Clear(false);
  const auto kept = innergs::recoveredFits(logic->GetRecoveryFolder());
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].iteration, kept[0].iterations);
  const auto request = requestFor(addSeries(9));
  request->SetResumeFileName(job->GetRecoveryFile());
  EXPECT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
  EXPECT_NE(logic->GetLastJob()->GetTableNode(), nullptr);
}

/// Given as an array, by a file, by the sequence's attributes and by the file beside its own: all the same.
TEST_F(DynamicTest, SlicesHaveTimesOfTheirOwn) {
  auto* series = addSeries(8); // 9 slices
  const auto request = requestFor(series);
  request->SetKind(vtkSlicerInnerGSDynamicRequest::Intensity);
  request->EvaluateQualityOff();
  const auto changes = [&] {
    EXPECT_TRUE(logic->ReconstructDynamic(request)) << logic->GetLastError();
    return logic->GetLastJob()->GetModelNode()->GetDynamicModel()->GetField()->changes;
  };
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return (folder / name).string();
  };
  const std::vector<float> atOnce = changes();
  const double order[] = {0, 5, 1, 6, 2, 7, 3, 8, 4};
  vtkNew<vtkDoubleArray> times;
  std::string list, back;
  for (const double o : order) {
    times->InsertNextValue(0.025 * o);
    const std::string text = std::to_string(0.025 * o);
    list += (list.empty() ? "" : ", ") + text;
    back = text + (back.empty() ? "" : ", ") + back;
  }
  request->SetSliceTimes(times);
  const std::vector<float> timed = changes();
  EXPECT_NE(timed, atOnce);
  request->SetSliceTimes(nullptr);
  request->SetSliceTimingFileName(write("times.json", "{\"SliceTiming\": [" + list + "]}"));
  EXPECT_EQ(changes(), timed);
  request->SetSliceTimingFileName(write("times.txt", list));
  EXPECT_EQ(changes(), timed);
  request->SetSliceTimingFileName("");
  series->SetAttribute("InnerGS.SliceTiming", back.c_str());
  series->SetAttribute("InnerGS.SliceEncodingDirection", "k-");
  EXPECT_EQ(changes(), timed);
  request->SetSetting("sliceTiming", "false");
  EXPECT_EQ(changes(), atOnce);
  request->SetSetting("sliceTiming", "");
  series->RemoveAttribute("InnerGS.SliceTiming");
  series->AddDefaultStorageNode();
  ASSERT_NE(series->GetStorageNode(), nullptr);
  series->GetStorageNode()->SetFileName((folder / "times.nii.gz").string().c_str());
  EXPECT_EQ(changes(), timed);

  series->SetAttribute("InnerGS.SliceTiming", "0 1");
  EXPECT_NE(logic->CheckDynamicRequest(request).find("2 slice times for 9 slices"), std::string::npos);
  series->SetAttribute("InnerGS.SliceTiming", "0 1 2 3 4 5 6 7 8"); // of frames 0.25 s apart
  EXPECT_NE(refusal(request).find("in seconds"), std::string::npos);
  request->SetSliceTimingFileName((folder / "gone.json").string());
  EXPECT_NE(refusal(request).find("does not exist"), std::string::npos);
  request->SetSliceTimingFileName(write("none.json", "{}"));
  EXPECT_NE(refusal(request).find("no SliceTiming"), std::string::npos);
}

TEST_F(DynamicTest, WhatIsWrongIsOneSentence) {
  EXPECT_NE(refusal(requestFor(nullptr)).find("no dynamic scan"), std::string::npos);
  EXPECT_NE(refusal(requestFor(addSeries(1))).find("single frame"), std::string::npos);
  const auto counted = requestFor(addSeries(4, ""));
  EXPECT_NE(refusal(counted).find("no unit of time"), std::string::npos);
  counted->SetInterval(0.25);
  EXPECT_EQ(logic->CheckDynamicRequest(counted), "");
  counted->SetRate(-1);
  EXPECT_NE(refusal(counted).find("above 0"), std::string::npos);
  auto* other = addSeries(3);
  vtkNew<vtkMRMLScalarVolumeNode> odd;
  vtkNew<vtkImageData> image;
  image->SetDimensions(4, 4, 4);
  image->AllocateScalars(VTK_SHORT, 1);
  odd->SetAndObserveImageData(image);
  other->SetDataNodeAtValue(odd, "9");
  EXPECT_NE(refusal(requestFor(other)).find("another grid"), std::string::npos);
  ASSERT_TRUE(logic->Reconstruct(addParameters(addVolume())));
  vtkMRMLInnerGSModelNode* still = logic->GetLastJob()->GetModelNode();
  EXPECT_EQ(logic->CreateFrames(still), nullptr);
  EXPECT_NE(logic->GetLastError().find("not of a dynamic scan"), std::string::npos);
}

} // namespace
