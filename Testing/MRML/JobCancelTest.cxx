#include "JobFixture.h"
#include "vtkInnerGSReconstruct.h"

namespace {

// Cancels from every progress event, one job each, until one takes effect.
TEST_F(JobTest, CancelAtEveryProgressEvent) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(12);
  int cancelled = 0, finished = 0;
  for (int stopAt = 1; finished == 0; ++stopAt) {
    ASSERT_LT(stopAt, 200);
    int count = 0;
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
      if (++count == stopAt) logic->Cancel(jobOf(data));
    });
    const bool done = logic->Reconstruct(parameters);
    EXPECT_EQ(logic->GetNumberOfJobs(), 0);
    const int state = logic->GetLastJob()->GetState();
    EXPECT_EQ(state, done ? vtkSlicerInnerGSJob::Finished : vtkSlicerInnerGSJob::Cancelled);
    if (done) { // only if it had already finished
      EXPECT_LT(count, stopAt);
      ++finished;
    }
    cancelled += !done;
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), done ? 1 : 0);
  }
  EXPECT_GT(cancelled, 0); // a busy machine delivers few events
  EXPECT_TRUE(errors.empty());
}

TEST_F(JobTest, RequestCancelDoesNotWait) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr);
  while (job->GetCurrentIteration() == 0)
    logic->WaitForJob(job, 0.01);
  int ends = 0;
  Observer watch(logic, {Logic::JobCancelledEvent}, [&](unsigned long, void*) { ++ends; });
  logic->RequestCancel(job);
  EXPECT_FALSE(job->IsDone()); // the main thread has not been notified of the end
  EXPECT_EQ(ends, 0);
  EXPECT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(ends, 1);
  EXPECT_TRUE(errors.empty());
}

// The worker finishes before the main thread is notified of anything: whatever an observer then does still
// takes effect.
class LateObserverTest : public JobTest, public testing::WithParamInterface<unsigned long> {
protected:
  void run(const std::function<void(vtkSlicerInnerGSJob*)>& act) {
    auto* parameters = addParameters(addVolume());
    parameters->SetNumberOfIterations(2);
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
    ASSERT_NE(job, nullptr);
    waitForWorker();
    std::vector<unsigned long> order;
    Observer watch(logic,
                   {Logic::JobStartedEvent, Logic::JobProgressEvent, Logic::JobPreviewEvent,
                    Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                   [&](unsigned long event, void* data) {
                     if (jobOf(data) != job) return;
                     order.push_back(event);
                     if (event == GetParam()) act(jobOf(data));
                   });
    ASSERT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
    EXPECT_EQ(order.back(), Logic::JobCancelledEvent);
    EXPECT_EQ(std::count(order.begin(), order.end(), Logic::JobCancelledEvent), 1);
    EXPECT_NE(std::find(order.begin(), order.end(), GetParam()), order.end());
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  }
};

TEST_P(LateObserverTest, Cancel) {
  run([&](vtkSlicerInnerGSJob* job) {
    logic->Cancel(job);
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  });
  EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 1);
}

TEST_P(LateObserverTest, ClearScene) {
  run([&](vtkSlicerInnerGSJob*) { scene->Clear(false); });
  EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 0);
}

TEST_P(LateObserverTest, RemoveParameterNode) {
  run([&](vtkSlicerInnerGSJob* job) { scene->RemoveNode(job->GetParameterNode()); });
  EXPECT_EQ(countNodes("vtkMRMLScalarVolumeNode"), 1);
}

INSTANTIATE_TEST_SUITE_P(Events, LateObserverTest,
                         testing::Values(Logic::JobStartedEvent, Logic::JobProgressEvent));

TEST_F(JobTest, SceneClearedWhileQualityIsJudged) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(1);
  parameters->SetEvaluateQuality(true);
  bool cleared = false;
  Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
    if (cleared || !jobOf(data)->IsJudging()) return;
    cleared = true;
    scene->Clear(false);
  });
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_TRUE(cleared);
  EXPECT_EQ(logic->GetLastJob()->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
}

TEST_F(JobTest, CancelWhileTheUncertaintyIsEstimatedKeepsTheResult) {
  auto* parameters = addParameters(addLargerVolume());
  parameters->SetNumberOfIterations(5);
  parameters->EstimateUncertaintyOn();
  bool cancelled = false;
  Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
    auto* job = jobOf(data);
    if (cancelled || job->GetPhase() != "Estimating the uncertainty") return;
    EXPECT_TRUE(job->IsJudging());
    cancelled = true;
    logic->Cancel(job);
  });
  EXPECT_TRUE(logic->Reconstruct(parameters));
  EXPECT_TRUE(cancelled);
  auto* job = logic->GetLastJob();
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  EXPECT_NE(job->GetVolumeNode(), nullptr);
  EXPECT_NE(job->GetModelNode(), nullptr);
  EXPECT_EQ(job->GetUncertaintyNode(), nullptr);
  EXPECT_TRUE(std::isfinite(job->GetHeldOutPSNR()));
  ASSERT_GT(job->GetNumberOfWarnings(), 0);
  EXPECT_NE(job->GetWarning(job->GetNumberOfWarnings() - 1).find("uncertainty"), std::string::npos);
}

// In the second fit and in the interpolations that it is compared with.
TEST_F(JobTest, CancelWhileQualityIsJudged) {
  const int size[3] = {160, 160, 120};
  vtkNew<vtkMatrix4x4> matrix;
  auto* parameters = addParameters(addVolume("Large", size, matrix));
  parameters->SetNumberOfIterations(1);
  parameters->SetNumberOfGaussians(2000);
  parameters->SetEvaluateQuality(true);
  for (const bool interpolating : {false, true}) {
    double last = 0;
    bool cancelled = false, fitted = false; // fitted: the second fit has reported iterations
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
      auto* job = jobOf(data);
      EXPECT_GE(job->GetProgress(), last);
      EXPECT_LE(job->GetProgress(), 1);
      last = job->GetProgress();
      if (cancelled || !job->IsJudging()) return;
      fitted = fitted || job->GetTotalIterations() > 0;
      if (!fitted || (interpolating && job->GetTotalIterations() > 0)) return;
      cancelled = true;
      logic->Cancel(job);
    });
    EXPECT_TRUE(logic->Reconstruct(parameters)); // the complete fit is kept
    auto* job = logic->GetLastJob();
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << interpolating;
    EXPECT_EQ(job->GetQualityState(), vtkInnerGSReconstruct::QualityStopped);
    EXPECT_NE(job->GetVolumeNode(), nullptr);
    ASSERT_NE(job->GetModelNode(), nullptr);
    EXPECT_FALSE(job->GetModelNode()->IsEmpty());
    EXPECT_EQ(job->GetTableNode(), nullptr);
    ASSERT_GT(job->GetNumberOfWarnings(), 0);
    EXPECT_NE(job->GetWarning(job->GetNumberOfWarnings() - 1).find("stopped"), std::string::npos);
    EXPECT_TRUE(cancelled) << interpolating;
  }
  EXPECT_EQ(countNodes("vtkMRMLTableNode"), 0);
  EXPECT_TRUE(errors.empty());
}

} // namespace
