#include "JobFixture.h"

namespace {

TEST_F(JobTest, EventsOnTheMainThreadInOrder) {
  const auto main = std::this_thread::get_id();
  std::vector<unsigned long> order;
  double last = 0;
  vtkSmartPointer<vtkSlicerInnerGSJob> job;
  Observer watch(logic,
                 {Logic::JobStartedEvent, Logic::JobProgressEvent, Logic::JobPreviewEvent,
                  Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                 [&](unsigned long event, void* data) {
                   if (jobOf(data) != job) return;
                   EXPECT_EQ(std::this_thread::get_id(), main);
                   if (order.empty() || order.back() != event) order.push_back(event);
                   EXPECT_GE(jobOf(data)->GetProgress(), last);
                   last = jobOf(data)->GetProgress();
                   EXPECT_FALSE(jobOf(data)->GetDescription().empty());
                 });
  job = logic->StartReconstruction(addParameters(addVolume()));
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  EXPECT_EQ(logic->GetNumberOfJobs(), 1);
  waitForWorker();
  EXPECT_TRUE(order.empty()); // nothing without polling
  waitUntil([&] { return !logic->IsRunning(); });
  ASSERT_GE(order.size(), 3u);
  EXPECT_EQ(order.front(), Logic::JobStartedEvent);
  EXPECT_EQ(order[1], Logic::JobProgressEvent);
  EXPECT_EQ(order.back(), Logic::JobFinishedEvent);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  EXPECT_EQ(job->GetProgress(), 1);
}

TEST_F(JobTest, OtherThreadsAreRefused) {
  auto* parameters = addParameters(addVolume());
  int processed = -1;
  bool started = true;
  std::thread([&] {
    processed = logic->ProcessPendingEvents();
    started = logic->Reconstruct(parameters);
  }).join();
  EXPECT_EQ(processed, 0);
  EXPECT_FALSE(started);
  EXPECT_NE(logic->GetLastError().find("main thread"), std::string::npos);
}

TEST_F(JobTest, PreviewHasDataAndGeometry) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  bool seen = false;
  Observer watch(logic, {Logic::JobPreviewEvent}, [&](unsigned long, void* data) {
    auto* job = jobOf(data);
    seen = true;
    ASSERT_NE(job->GetPreviewImage(), nullptr);
    double centre[4], at[4] = {0, 0, 0, 1};
    vtkNew<vtkMatrix4x4> toIJK;
    vtkMatrix4x4::Invert(job->GetPreviewIJKToRASMatrix(), toIJK);
    toIJK->MultiplyPoint(at, centre);
    EXPECT_NEAR(job->GetPreviewImage()->GetScalarComponentAsDouble(
                    static_cast<int>(std::lround(centre[0])), static_cast<int>(std::lround(centre[1])),
                    static_cast<int>(std::lround(centre[2])), 0),
                truth(0, 0, 0), 40);
    logic->Cancel(job);
  });
  ASSERT_FALSE(logic->Reconstruct(parameters));
  EXPECT_TRUE(seen);
  EXPECT_EQ(logic->GetLastJob()->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(logic->GetLastError(), "");
}

TEST_F(JobTest, NothingIsHeldOutBeforeItIsMeasured) {
  bool first = true;
  Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
    if (first) {
      EXPECT_TRUE(std::isnan(jobOf(data)->GetHeldOutPSNR())) << jobOf(data)->GetHeldOutPSNR();
    }
    first = false;
  });
  EXPECT_TRUE(logic->Reconstruct(addParameters(addVolume())));
  EXPECT_FALSE(first);
}

TEST_F(JobTest, QueueInOrderAndCancelOne) {
  auto* input = addVolume();
  auto* parameters = addParameters(input);
  std::vector<vtkSmartPointer<vtkSlicerInnerGSJob>> jobs;
  for (const int iterations : {100000, 30, 30, 30}) {
    parameters->SetNumberOfIterations(iterations);
    jobs.emplace_back(logic->StartReconstruction(parameters));
  }
  EXPECT_EQ(logic->GetNumberOfJobs(), 4);
  EXPECT_EQ(logic->GetCurrentJob(), jobs[0]);
  logic->Cancel(jobs[2]); // does not wait for earlier ones
  EXPECT_EQ(jobs[2]->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_FALSE(jobs[0]->IsDone());
  logic->Cancel(jobs[0]);
  std::vector<vtkSlicerInnerGSJob*> ended;
  Observer watch(logic, {Logic::JobFinishedEvent},
                 [&](unsigned long, void* data) { ended.push_back(jobOf(data)); });
  ASSERT_TRUE(logic->WaitForJob());
  EXPECT_EQ(ended, (std::vector<vtkSlicerInnerGSJob*>{jobs[1], jobs[3]}));
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 2);
  EXPECT_FALSE(logic->IsRunning());
  EXPECT_EQ(logic->GetCurrentJob(), nullptr);
}

// A job started by an observer of another one's end.
TEST_F(JobTest, SequenceFromAnObserver) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(5);
  int runs = 0;
  Observer watch(logic, {Logic::JobFinishedEvent}, [&](unsigned long, void*) {
    ++runs;
    if (runs < 3) {
      EXPECT_NE(logic->StartReconstruction(parameters), nullptr);
    } else if (runs == 3) {
      EXPECT_TRUE(logic->Reconstruct(parameters)); // blocking, inside an event
    }
  });
  ASSERT_NE(logic->StartReconstruction(parameters), nullptr);
  ASSERT_TRUE(logic->WaitForJob(nullptr, 60));
  EXPECT_EQ(runs, 4);
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 4);
}

TEST_F(JobTest, SameSeedSameResult) {
  auto* parameters = addParameters(addVolume());
  ASSERT_TRUE(logic->Reconstruct(parameters));
  auto* first = logic->GetLastJob()->GetVolumeNode()->GetImageData();
  parameters->SetNumberOfThreads(1);
  ASSERT_TRUE(logic->Reconstruct(parameters));
  auto* second = logic->GetLastJob()->GetVolumeNode()->GetImageData();
  ASSERT_EQ(first->GetNumberOfPoints(), second->GetNumberOfPoints());
  EXPECT_EQ(std::memcmp(first->GetScalarPointer(), second->GetScalarPointer(),
                        sizeof(float) * static_cast<std::size_t>(first->GetNumberOfPoints())),
            0);
}

// The engine reports it once; it must arrive even if other reports are skipped.
TEST_F(JobTest, SaysWhereItRunsAndWhy) {
  auto* parameters = addParameters(addThickVolume());
  parameters->SetDevice("cpu");
  parameters->SetNumberOfIterations(5);
  parameters->SetEvaluateQuality(true);
  parameters->SetQualityGap(2);
  const std::string onTheCpu = logic->DescribeDevice(parameters);
  EXPECT_NE(onTheCpu.find("as asked"), std::string::npos) << onTheCpu;
  EXPECT_EQ(logic->DescribeDevice(nullptr), "");
  int fitting = 0;
  vtkSmartPointer<vtkSlicerInnerGSJob> job;
  Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
    if (jobOf(data) != job || job->GetCurrentIteration() == 0) return;
    ++fitting;
    EXPECT_EQ(job->GetDeviceNote(), onTheCpu) << job->GetPhase();
  });
  job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr);
  EXPECT_EQ(job->GetDeviceNote(), "");
  waitForWorker(); // many reports become one
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_GT(fitting, 0);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  EXPECT_EQ(job->GetDeviceNote(), onTheCpu);
  parameters->SetDevice("cuda:999");
  EXPECT_NE(logic->DescribeDevice(parameters), "");
}

} // namespace
