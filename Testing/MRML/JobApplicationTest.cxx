#include "JobFixture.h"

#include <vtkSlicerApplicationLogic.h>

#include <vtkWeakPointer.h>

namespace {

// A loop in the application's console blocks its event loop, so asking delivers the events.
TEST_F(JobTest, AskingEndsWithAnApplication) {
  vtkNew<vtkSlicerApplicationLogic> application;
  application->SetMRMLScene(scene);
  application->CreateProcessingThread();
  logic->SetMRMLApplicationLogic(application);
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(5);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  waitUntil([&] { return !logic->IsRunning(); });
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  application->TerminateProcessingThread();
  logic->SetMRMLApplicationLogic(nullptr);
}

// As in the application: its logic's queue signals on the main thread, and nothing polls for events.
TEST_F(JobTest, DeliveredByTheApplicationsEventLoop) {
  vtkNew<vtkSlicerApplicationLogic> application;
  application->SetMRMLScene(scene);
  application->CreateProcessingThread();
  logic->SetMRMLApplicationLogic(application);
  const auto main = std::this_thread::get_id();
  int progress = 0, finished = 0;
  Observer watch(logic, {Logic::JobProgressEvent, Logic::JobFinishedEvent}, [&](unsigned long event, void*) {
    EXPECT_EQ(std::this_thread::get_id(), main);
    ++(event == Logic::JobFinishedEvent ? finished : progress);
  });
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(300);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr);
  waitUntil([&] {
    application->ProcessModified(); // called by the application's timer
    return job->IsDone();
  });
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  EXPECT_GT(progress, 1);
  EXPECT_EQ(finished, 1);

  parameters->SetNumberOfIterations(100000);
  job = logic->StartReconstruction(parameters);
  for (int n = 0; n < 5; ++n)
    application->ProcessModified();
  logic->Cancel(job); // and a regular end with the queue in use
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  application->TerminateProcessingThread();
  logic->SetMRMLApplicationLogic(nullptr);
}

// The application's logic is deleted first, or replaced, while the worker is about to signal.
TEST_F(JobTest, ApplicationLogicGoesWhileRunning) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  vtkSmartPointer<vtkSlicerInnerGSJob> job;
  for (int round = 0; round < 3; ++round) {
    auto application = vtkSmartPointer<vtkSlicerApplicationLogic>::New();
    application->CreateProcessingThread();
    logic->SetMRMLApplicationLogic(application);
    if (!job) job = logic->StartReconstruction(parameters);
    ASSERT_NE(job, nullptr);
    int count = 0; // a new one is signalled for what the old one did not pass on
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void*) { ++count; });
    waitUntil([&] {
      application->ProcessModified();
      return count >= 2;
    });
    vtkWeakPointer<vtkSlicerApplicationLogic> weak = application.Get();
    application->TerminateProcessingThread();
    application = nullptr;
    EXPECT_EQ(weak, nullptr);
    EXPECT_EQ(logic->GetApplicationLogic(), nullptr);
  }
  EXPECT_TRUE(logic->IsRunning());
  logic->Cancel();
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
}

} // namespace
