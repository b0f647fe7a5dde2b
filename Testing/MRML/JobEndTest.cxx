#include "JobFixture.h"
#include "ThreadShortage.h"

namespace {

bool isOutput(vtkMRMLNode* node) {
  return node->IsA("vtkMRMLInnerGSModelNode") || node->IsA("vtkMRMLScalarVolumeNode") ||
         node->IsA("vtkMRMLTableNode");
}

TEST_F(JobTest, SceneClearedWhileRunning) {
  for (const int when : {0, 3, 10}) {
    auto* parameters = addParameters(addVolume());
    parameters->SetNumberOfIterations(100000);
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
    ASSERT_NE(job, nullptr);
    ASSERT_NE(logic->StartReconstruction(parameters), nullptr); // one that waits
    int count = 0;
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void*) { ++count; });
    while (count < when)
      logic->WaitForJob(job, 0.01);
    scene->Clear(false);
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
    EXPECT_EQ(job->GetParameterNode(), nullptr);
    EXPECT_EQ(logic->GetNumberOfJobs(), 0);
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  }
  EXPECT_TRUE(logic->Reconstruct(addParameters(addVolume()))); // the logic goes on
}

TEST_F(JobTest, ClearedAfterTheEndButBeforeItsDelivery) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(2);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  waitForWorker();
  scene->Clear(false);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 0);
}

TEST_F(JobTest, NodesRemovedOrEditedWhileRunning) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(200);
  auto* output = addVolume("Output");
  parameters->SetOutputVolumeNode(output);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  // The job works on what was there at the start.
  input->GetImageData()->GetPointData()->GetScalars()->Fill(0);
  scene->RemoveNode(input);
  scene->RemoveNode(output);
  parameters->SetPreset(vtkMRMLInnerGSParameterNode::Best);
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  ASSERT_NE(job->GetVolumeNode(), nullptr); // a new one: the result is not lost
  EXPECT_EQ(job->GetVolumeNode()->GetScene(), scene.Get());
  EXPECT_STRNE(job->GetVolumeNode()->GetName(), "Output");
  EXPECT_LT(error(job->GetVolumeNode()), 10);
  ASSERT_NE(job->GetModelNode(), nullptr);
  EXPECT_EQ(job->GetNumberOfWarnings(), 1);
  EXPECT_NEAR(logic->GetValueAtRAS(job->GetModelNode(), 0, 0, 0), truth(0, 0, 0), 10);

  // Without its parameter node a job has no purpose.
  parameters->SetInputVolumeNode(addVolume());
  parameters->SetNumberOfIterations(100000);
  job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  scene->RemoveNode(parameters);
  ASSERT_TRUE(logic->WaitForJob(job, 10));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
}

// The result is the same when the worker makes the copy, and its refusals are reported like any failure.
TEST_F(JobTest, VoxelsCopiedByTheWorker) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(20);
  parameters->SetMaskNode(addVolume("Mask"));
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  const vtkSmartPointer<vtkImageData> copied = logic->GetLastJob()->GetVolumeNode()->GetImageData();
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, false);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  vtkSmartPointer<vtkSlicerInnerGSJob> next = logic->StartReconstruction(parameters, false);
  ASSERT_NE(next, nullptr);
  scene->RemoveNode(input);
  ASSERT_TRUE(logic->WaitForJob(job));
  ASSERT_TRUE(logic->WaitForJob(next));
  for (const auto& ended : {job, next}) {
    ASSERT_EQ(ended->GetState(), vtkSlicerInnerGSJob::Finished) << ended->GetErrorMessage();
    vtkImageData* shared = ended->GetVolumeNode()->GetImageData();
    ASSERT_EQ(shared->GetNumberOfPoints(), copied->GetNumberOfPoints());
    EXPECT_EQ(std::memcmp(shared->GetScalarPointer(), copied->GetScalarPointer(),
                          sizeof(float) * static_cast<std::size_t>(copied->GetNumberOfPoints())),
              0);
  }
  auto* empty = addVolume("Empty");
  empty->GetImageData()->GetPointData()->GetScalars()->Fill(0);
  auto* other = addVolume("Other");
  parameters->SetInputVolumeNode(other);
  parameters->SetMaskNode(empty); // nothing to fit
  job = logic->StartReconstruction(parameters, false);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_NE(job->GetErrorMessage(), "");
}

TEST_F(JobTest, LogicAndSceneGoWhileRunning) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  auto other = anotherLogic();
  vtkSmartPointer<vtkSlicerInnerGSJob> job = other->StartReconstruction(parameters);
  vtkSmartPointer<vtkSlicerInnerGSJob> waiting = other->StartReconstruction(parameters);
  other = nullptr;
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(waiting->GetState(), vtkSlicerInnerGSJob::Cancelled);

  job = logic->StartReconstruction(parameters);
  vtkNew<vtkMRMLScene> another;
  logic->SetMRMLScene(another);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  logic->SetMRMLScene(nullptr);
  EXPECT_FALSE(logic->Reconstruct(parameters));
}

// An observer that lets go of the logic: the call in progress must still end well.
TEST_F(JobTest, LogicDroppedByAnObserver) {
  auto* parameters = addParameters(addVolume());
  auto other = anotherLogic();
  Logic* raw = other;
  vtkNew<vtkCallbackCommand> drop;
  drop->SetClientData(&other);
  drop->SetCallback([](vtkObject*, unsigned long, void* pointer, void*) {
    *static_cast<vtkSmartPointer<Logic>*>(pointer) = nullptr;
  });
  other->AddObserver(Logic::JobProgressEvent, drop);
  raw->Reconstruct(parameters);
  EXPECT_EQ(other, nullptr);
}

// The same from the question that scripts ask.
TEST_F(JobTest, LogicDroppedWhileAskedWhetherItRuns) {
  auto* parameters = addParameters(addVolume());
  auto other = anotherLogic();
  Logic* raw = other;
  ASSERT_NE(raw->StartReconstruction(parameters), nullptr);
  vtkNew<vtkCallbackCommand> drop;
  drop->SetClientData(&other);
  drop->SetCallback([](vtkObject*, unsigned long, void* pointer, void*) {
    *static_cast<vtkSmartPointer<Logic>*>(pointer) = nullptr;
  });
  other->AddObserver(Logic::JobProgressEvent, drop);
  waitUntil([&] { return !other || !raw->IsRunning(); });
  EXPECT_EQ(other, nullptr);
}

// Nodes go, or the scene is cleared, by an observer of the outputs as they are made.
TEST_F(JobTest, SceneChangedWhileOutputsAreMade) {
  for (const bool clear : {false, true})
    for (int when = 1;; ++when) {
      ASSERT_LT(when, 50);
      auto* parameters = addParameters(addVolume());
      parameters->SetNumberOfIterations(2);
      parameters->SetEvaluateQuality(true);
      vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
      ASSERT_NE(job, nullptr);
      int count = 0, ends = 0;
      Observer watch(scene, {vtkMRMLScene::NodeAddedEvent}, [&](unsigned long, void* node) {
        auto* added = static_cast<vtkMRMLNode*>(node);
        if (!isOutput(added) || ++count != when) return;
        if (clear)
          scene->Clear(false);
        else
          scene->RemoveNode(added);
      });
      Observer end(logic, {Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                   [&](unsigned long, void*) { ++ends; });
      ASSERT_TRUE(logic->WaitForJob(job, 60));
      EXPECT_EQ(ends, 1);
      if (clear && count >= when) {
        EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
        EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
        EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 0);
      } else {
        EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
      }
      scene->Clear(false);
      if (count < when) break;
    }
}

TEST_F(JobTest, FailsWithASentenceWithoutAThread) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(2);
  parameters->SetNumberOfThreads(1);
  vtkSmartPointer<vtkSlicerInnerGSJob> job;
  int failed = 0;
  Observer watch(logic, {Logic::JobFailedEvent}, [&](unsigned long, void*) { ++failed; });
  {
    if (!innergs::test::ThreadShortage::known())
      GTEST_SKIP() << "this system's threads cannot be refused here";
    const innergs::test::ThreadShortage shortage(0);
    job = logic->StartReconstruction(parameters);
  }
  ASSERT_NE(job, nullptr);
  ASSERT_TRUE(logic->WaitForJob(job, 10));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_FALSE(job->GetErrorMessage().empty());
  EXPECT_EQ(failed, 1);
  EXPECT_TRUE(logic->Reconstruct(parameters)); // and again
}

// Its observers may be going as well, Python's for one: no event.
TEST_F(JobTest, CancelledWithoutAnEventWhenTheLogicGoes) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  auto other = anotherLogic();
  std::vector<vtkSmartPointer<vtkSlicerInnerGSJob>> jobs{other->StartReconstruction(parameters),
                                                         other->StartReconstruction(parameters)};
  std::vector<void*> ended;
  vtkNew<vtkCallbackCommand> listen;
  listen->SetClientData(&ended);
  listen->SetCallback([](vtkObject*, unsigned long, void* list, void* job) {
    static_cast<std::vector<void*>*>(list)->push_back(job);
  });
  other->AddObserver(Logic::JobCancelledEvent, listen);
  other = nullptr;
  EXPECT_TRUE(ended.empty());
  for (const auto& job : jobs)
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
}

} // namespace
