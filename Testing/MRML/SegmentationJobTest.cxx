#include "SegmentationFixture.h"
#include "vtkInnerGSAlgorithm.h"

#include <vtkSegmentationConverterFactory.h>

namespace {

using SegmentationJobTest = SegmentationFixture;

// Only copies are made on the main thread: what the work finds out is not known there, and the rules that
// make voxels of surfaces run elsewhere.
TEST_F(SegmentationJobTest, WorkAndItsErrorsAreTheWorkers) {
  const auto matrix = matrixOf(input);
  const int whole[6] = {2, 19, 1, 18, 0, 17};
  addSegment("Blank", balls(matrix, whole, VTK_UNSIGNED_CHAR, {}));
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(2);
  parameters->SetMaskNode(node);
  for (const bool copy : {true, false}) {
    errors.clear();
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    ASSERT_NE(job, nullptr) << logic->GetLastError();
    ASSERT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
    EXPECT_EQ(job->GetErrorCode(), vtkInnerGSAlgorithm::NoDataError) << job->GetErrorMessage();
    EXPECT_EQ(errors.size(), 1u);
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  }
  segments->RemoveAllSegments();
  addSurface("Ball", 0, 12);
  for (const bool copy : {true, false}) {
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    ASSERT_NE(job, nullptr) << logic->GetLastError();
    ASSERT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
  }
  EXPECT_FALSE(WatchedRule::threads.empty());
  EXPECT_EQ(WatchedRule::threads.count(std::this_thread::get_id()), 0u);
  EXPECT_FALSE(segments->ContainsRepresentation(kLabelmap));

  // Slicer's labelmap of a surface cannot be made of one that is none.
  segments->RemoveAllSegments();
  addSegment("None", vtkNew<vtkPolyData>());
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_EQ(job->GetErrorCode(), vtkInnerGSAlgorithm::NoDataError) << job->GetErrorMessage();
}

TEST_F(SegmentationJobTest, SurfacesWithoutARule) {
  auto* rules = vtkSegmentationConverterFactory::GetInstance();
  const auto before = rules->GetConverterRules();
  for (const auto& other : before)
    rules->UnregisterConverterRule(other);
  addSurface("Ball", 0, 12);
  auto* parameters = addParameters(input);
  parameters->SetMaskNode(node);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_EQ(job->GetErrorCode(), vtkInnerGSAlgorithm::UnsupportedImageError) << job->GetErrorMessage();
  for (const auto& other : before)
    rules->RegisterConverterRule(other);
}

// Slicer's rules know no stop: the job ends, the rule when it is through, and the logic not before it.
TEST_F(SegmentationJobTest, CancelWhileSurfacesAreMadeVoxels) {
  addSurface("Left", -7, 9);
  addSurface("Right", 8, 7);
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(2);
  parameters->SetMaskNode(node);
  auto other = anotherLogic();
  WatchedRule::held = true;
  vtkSmartPointer<vtkSlicerInnerGSJob> job = other->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr) << other->GetLastError();
  WatchedRule::waitForEntry();
  other->Cancel(job); // would wait for ever
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  parameters->SetMaskNode(nullptr);
  EXPECT_TRUE(other->Reconstruct(parameters)) << other->GetLastError(); // the next one does not wait for it
  vtkNew<vtkCallbackCommand> release;
  release->SetCallback([](vtkObject*, unsigned long, void*, void*) {
    std::lock_guard lock(WatchedRule::mutex);
    WatchedRule::held = false;
    WatchedRule::changed.notify_all();
  });
  other->AddObserver(vtkCommand::DeleteEvent, release);
  other = nullptr;
  EXPECT_EQ(WatchedRule::done, 1); // no one holds the second surface any more
}

TEST_F(SegmentationJobTest, EditedOrRemovedAfterTheStart) {
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(5);
  const auto start = [&](bool copy) {
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    EXPECT_NE(job, nullptr) << logic->GetLastError();
    return job;
  };
  const auto resultOf = [&](vtkSlicerInnerGSJob* job) {
    EXPECT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
    std::vector<float> values;
    if (auto* volume = job->GetVolumeNode()) {
      const auto* first = static_cast<const float*>(volume->GetImageData()->GetScalarPointer());
      values.assign(first, first + volume->GetImageData()->GetNumberOfPoints());
    }
    return values;
  };
  const std::vector<float> unmasked = resultOf(start(true));
  vtkSmartPointer<vtkMRMLSegmentationNode> kept = node; // when it is removed
  const auto fill = [&] {
    if (node->GetScene() != scene.Get()) {
      node = addNode<vtkMRMLSegmentationNode>();
    }
    kept = node;
    segments = node->GetSegmentation();
    segments->RemoveAllSegments();
    segments->SetSourceRepresentationName(kLabelmap);
    parameters->SetMaskNode(node);
  };
  for (const bool surfaces : {false, true}) {
    const auto draw = [&] {
      fill();
      if (surfaces)
        addSurface("Ball", 2, 12);
      else
        addLabelmaps();
    };
    draw();
    const std::vector<float> before = resultOf(start(true));
    EXPECT_NE(before, unmasked);
    for (const bool copy : {true, false})
      for (const int edit : {0, 1, 2}) {
        SCOPED_TRACE(testing::Message() << "surfaces " << surfaces << ", copy " << copy << ", edit " << edit);
        draw();
        vtkSmartPointer<vtkSlicerInnerGSJob> job = start(copy);
        if (edit == 0) {
          scene->RemoveNode(node);
        } else if (edit == 1) {
          segments->RemoveAllSegments();
        } else if (surfaces) {
          segments->GetNthSegment(0)->AddRepresentation(kSurface, vtkNew<vtkPolyData>());
        } else { // as the segment editor paints
          auto* image =
              vtkOrientedImageData::SafeDownCast(segments->GetSegment("Two")->GetRepresentation(kLabelmap));
          image->GetPointData()->GetScalars()->Fill(2);
          image->Modified();
        }
        EXPECT_EQ(resultOf(job), before);
      }
  }
  EXPECT_TRUE(errors.empty());
}

// On the finest voxels of all, as Slicer merges, there can be too many.
TEST_F(SegmentationJobTest, SegmentsTooFineToMerge) {
  addLabelmaps();
  vtkNew<vtkMatrix4x4> fine;
  for (int a = 0; a < 3; ++a)
    fine->SetElement(a, a, 0.002);
  const int few[6] = {0, 3, 0, 3, 0, 3};
  addSegment("Fine", balls(fine, few, VTK_UNSIGNED_CHAR, {{0, 0, 0, 1}}));
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(2);
  parameters->SetMaskNode(node);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("choose one segment"), std::string::npos) << logic->GetLastError();
  parameters->SetMaskSegmentID("One");
  EXPECT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
}

// A segmentation somewhere else.
TEST_F(SegmentationJobTest, MaskBesideTheImages) {
  const auto matrix = matrixOf(input);
  const int beside[6] = {60, 80, 60, 80, 60, 80};
  addSegment("Far", balls(matrix, beside, VTK_UNSIGNED_CHAR, {{120, 120, 120, 30}}));
  auto* parameters = addParameters(input);
  parameters->SetMaskNode(node);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("holds no centre"), std::string::npos) << logic->GetLastError();
}

TEST_F(SegmentationJobTest, CancelWhileLabelmapsAreMergedAndBefore) {
  addLabelmaps();
  auto* parameters = addParameters(input);
  parameters->SetMaskNode(node);
  for (const bool copy : {true, false})
    for (const bool running : {true, false}) {
      vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
      ASSERT_NE(job, nullptr) << logic->GetLastError();
      while (running && job->GetState() == vtkSlicerInnerGSJob::Queued)
        logic->WaitForJob(job, 0.001);
      logic->Cancel(job);
      EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
      EXPECT_EQ(job->GetErrorMessage(), "");
    }
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  EXPECT_TRUE(errors.empty());
}

} // namespace
