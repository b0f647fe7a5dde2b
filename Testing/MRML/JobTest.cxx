#include "MrmlFixture.h"

#include <vtkSlicerApplicationLogic.h>

#include <vtkWeakPointer.h>

#include <chrono>
#include <thread>

namespace {

using JobTest = MrmlFixture;
using Logic = vtkSlicerInnerGSLogic;
using Clock = std::chrono::steady_clock;

bool isOutput(vtkMRMLNode* node) {
  return node->IsA("vtkMRMLInnerGSModelNode") || node->IsA("vtkMRMLScalarVolumeNode") ||
         node->IsA("vtkMRMLTableNode");
}

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

vtkSlicerInnerGSJob* jobOf(void* callData) {
  return static_cast<vtkSlicerInnerGSJob*>(callData);
}

TEST_F(JobTest, EventsOnTheMainThreadInOrder) {
  const auto main = std::this_thread::get_id();
  std::vector<unsigned long> order;
  double last = 0;
  Observer watch(logic,
                 {Logic::JobStartedEvent, Logic::JobProgressEvent, Logic::JobPreviewEvent,
                  Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                 [&](unsigned long event, void* data) {
                   EXPECT_EQ(std::this_thread::get_id(), main);
                   if (order.empty() || order.back() != event) order.push_back(event);
                   EXPECT_GE(jobOf(data)->GetProgress(), last);
                   last = jobOf(data)->GetProgress();
                   EXPECT_FALSE(jobOf(data)->GetDescription().empty());
                 });
  auto* job = logic->StartReconstruction(addParameters(addVolume()));
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  EXPECT_EQ(logic->GetNumberOfJobs(), 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(order.empty()); // nothing without asking
  while (logic->IsRunning())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
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
    EXPECT_NEAR(job->GetPreviewImage()->GetScalarComponentAsDouble(int(centre[0] + .5), int(centre[1] + .5),
                                                                   int(centre[2] + .5), 0),
                truth(0, 0, 0), 40);
    logic->Cancel(job);
  });
  const auto start = Clock::now();
  ASSERT_FALSE(logic->Reconstruct(parameters));
  EXPECT_TRUE(seen);
  EXPECT_LT(since(start), 10);
  EXPECT_EQ(logic->GetLastJob()->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(logic->GetLastError(), "");
}

// Cancel from every progress event, one job each, until one gets through.
TEST_F(JobTest, CancelAtEveryProgressEvent) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(12);
  parameters->SetHeldOutFraction(0.2);
  int cancelled = 0, finished = 0;
  double slowest = 0;
  for (int stopAt = 1; finished == 0; ++stopAt) {
    ASSERT_LT(stopAt, 200);
    int count = 0;
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
      if (++count != stopAt) return;
      const auto start = Clock::now();
      logic->Cancel(jobOf(data));
      slowest = std::max(slowest, since(start));
    });
    const bool done = logic->Reconstruct(parameters);
    EXPECT_EQ(logic->GetNumberOfJobs(), 0);
    const int state = logic->GetLastJob()->GetState();
    EXPECT_EQ(state, done ? vtkSlicerInnerGSJob::Finished : vtkSlicerInnerGSJob::Cancelled);
    if (done) { // only when it was over before
      EXPECT_LT(count, stopAt);
      ++finished;
    }
    cancelled += !done;
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), done ? 1 : 0);
  }
  EXPECT_GT(cancelled, 3);
  EXPECT_LT(slowest, 0.5);
  EXPECT_TRUE(errors.empty());
}

// The worker is through before the main thread hears of anything: whatever an observer does then still
// counts.
class LateObserverTest : public JobTest, public testing::WithParamInterface<unsigned long> {
protected:
  void run(const std::function<void(vtkSlicerInnerGSJob*)>& act) {
    auto* parameters = addParameters(addVolume());
    parameters->SetNumberOfIterations(2);
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
    ASSERT_NE(job, nullptr);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    std::vector<unsigned long> order;
    Observer watch(logic,
                   {Logic::JobStartedEvent, Logic::JobProgressEvent, Logic::JobPreviewEvent,
                    Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                   [&](unsigned long event, void* data) {
                     order.push_back(event);
                     if (event == GetParam()) act(jobOf(data));
                   });
    ASSERT_TRUE(logic->WaitForJob(job, 20));
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

// The interpolations that the Gaussians are compared with and the scoring end as quickly as a fit.
TEST_F(JobTest, CancelWhileQualityIsJudged) {
  const int size[3] = {160, 160, 120};
  vtkNew<vtkMatrix4x4> matrix;
  auto* parameters = addParameters(addVolume("Large", size, matrix));
  parameters->SetNumberOfIterations(1);
  parameters->SetNumberOfGaussians(2000);
  parameters->SetEvaluateQuality(true);
  for (const char* method :
       {"Judging quality, linear", "Judging quality, cubic", "Judging quality, lanczos"}) {
    double took = -1, last = 0;
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void* data) {
      auto* job = jobOf(data);
      EXPECT_GE(job->GetProgress(), last);
      EXPECT_LE(job->GetProgress(), 1);
      last = job->GetProgress();
      if (took >= 0 || job->GetPhase() != method) return;
      const auto start = Clock::now();
      logic->Cancel(job);
      took = since(start);
    });
    EXPECT_FALSE(logic->Reconstruct(parameters));
    EXPECT_EQ(logic->GetLastJob()->GetState(), vtkSlicerInnerGSJob::Cancelled) << method;
    EXPECT_GE(took, 0) << method;
    EXPECT_LT(took, 0.3) << method;
  }
  EXPECT_EQ(countNodes("vtkMRMLTableNode"), 0);
  EXPECT_TRUE(errors.empty());
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
  parameters->SetNumberOfIterations(30);
  std::vector<vtkSmartPointer<vtkSlicerInnerGSJob>> jobs;
  for (int n = 0; n < 4; ++n)
    jobs.emplace_back(logic->StartReconstruction(parameters));
  EXPECT_EQ(logic->GetNumberOfJobs(), 4);
  EXPECT_EQ(logic->GetCurrentJob(), jobs[0]);
  const auto start = Clock::now();
  logic->Cancel(jobs[2]); // waiting: at once
  EXPECT_LT(since(start), 0.3);
  EXPECT_EQ(jobs[2]->GetState(), vtkSlicerInnerGSJob::Cancelled);
  std::vector<vtkSlicerInnerGSJob*> ended;
  Observer watch(logic, {Logic::JobFinishedEvent},
                 [&](unsigned long, void* data) { ended.push_back(jobOf(data)); });
  ASSERT_TRUE(logic->WaitForJob());
  EXPECT_EQ(ended, (std::vector<vtkSlicerInnerGSJob*>{jobs[0], jobs[1], jobs[3]}));
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 3);
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
    const auto start = Clock::now();
    scene->Clear(false);
    EXPECT_LT(since(start), 1);
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
  std::this_thread::sleep_for(std::chrono::milliseconds(500)); // done by now, not delivered
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
  EXPECT_EQ(job->GetVolumeNode(), nullptr);
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

TEST_F(JobTest, LogicAndSceneGoWhileRunning) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  auto other = vtkSmartPointer<Logic>::New();
  other->SetMRMLScene(scene);
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
  auto other = vtkSmartPointer<Logic>::New();
  other->SetMRMLScene(scene);
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
  auto other = vtkSmartPointer<Logic>::New();
  other->SetMRMLScene(scene);
  Logic* raw = other;
  ASSERT_NE(raw->StartReconstruction(parameters), nullptr);
  vtkNew<vtkCallbackCommand> drop;
  drop->SetClientData(&other);
  drop->SetCallback([](vtkObject*, unsigned long, void* pointer, void*) {
    *static_cast<vtkSmartPointer<Logic>*>(pointer) = nullptr;
  });
  other->AddObserver(Logic::JobProgressEvent, drop);
  while (other && raw->IsRunning())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(other, nullptr);
}

// A loop in the application's console keeps its event loop from running: the question itself delivers.
TEST_F(JobTest, AskingEndsWithAnApplication) {
  vtkNew<vtkSlicerApplicationLogic> application;
  application->SetMRMLScene(scene);
  application->CreateProcessingThread();
  logic->SetMRMLApplicationLogic(application);
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(5);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  const auto start = Clock::now();
  while (logic->IsRunning() && since(start) < 20)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  application->TerminateProcessingThread();
  logic->SetMRMLApplicationLogic(nullptr);
}

// As in the application: its logic's queue rings on the main thread, and nobody asks for events.
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
  const auto start = Clock::now();
  while (!job->IsDone() && since(start) < 60) {
    application->ProcessModified(); // what the application's timer calls
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished);
  EXPECT_GT(progress, 1);
  EXPECT_EQ(finished, 1);

  parameters->SetNumberOfIterations(100000);
  job = logic->StartReconstruction(parameters);
  for (int n = 0; n < 5; ++n)
    application->ProcessModified();
  logic->Cancel(job); // and an orderly end with the queue in use
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  application->TerminateProcessingThread();
  logic->SetMRMLApplicationLogic(nullptr);
}

// The application's logic goes first, or another takes its place, with the worker about to ring.
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
    int count = 0; // a new one is rung for what the old one did not pass on
    Observer watch(logic, {Logic::JobProgressEvent}, [&](unsigned long, void*) { ++count; });
    const auto start = Clock::now();
    while (count < 2 && since(start) < 10) {
      application->ProcessModified();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_GE(count, 2);
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

// Its observers may be going as well, Python's for one: no event.
TEST_F(JobTest, CancelledWithoutAnEventWhenTheLogicGoes) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(100000);
  auto other = vtkSmartPointer<Logic>::New();
  other->SetMRMLScene(scene);
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

} // namespace
