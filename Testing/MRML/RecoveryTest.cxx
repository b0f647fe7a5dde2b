#include "IO/ModelFile.h"
#include "IO/RecoveredFit.h"
#include "JobFixture.h"

#include <vtkMRMLTableNode.h>

#include <fstream>

namespace fs = std::filesystem;

namespace {

/// What ends a fit from outside leaves a file to go on from.
class RecoveryTest : public JobTest {
protected:
  vtkMRMLInnerGSParameterNode* addLongFit() {
    auto* parameters = addParameters(addVolume());
    parameters->SetDevice("cpu");
    parameters->SetNumberOfIterations(kIterations);
    return parameters;
  }
  vtkSmartPointer<vtkSlicerInnerGSJob> startAndReach(vtkMRMLInnerGSParameterNode* parameters, int iteration) {
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
    EXPECT_NE(job, nullptr) << logic->GetLastError();
    if (job)
      waitUntil([&] {
        logic->ProcessPendingEvents();
        return job->IsDone() || job->GetCurrentIteration() >= iteration;
      });
    return job;
  }
  std::vector<innergs::RecoveredFit> kept() { return innergs::recoveredFits(logic->GetRecoveryFolder()); }
  static std::shared_ptr<const innergs::Model> coreOf(vtkSlicerInnerGSJob* job) {
    return job->GetModelNode()->GetModel()->GetCoreModel();
  }

  static constexpr int kIterations = 1500;
};

TEST_F(RecoveryTest, ClosingTheSceneKeepsWhereTheFitStood) {
  auto* parameters = addLongFit();
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  const auto whole = coreOf(logic->GetLastJob());
  std::vector<std::string> warnings;
  Observer onWarning(logic, {vtkCommand::WarningEvent},
                     [&](unsigned long, void* text) { warnings.emplace_back(static_cast<char*>(text)); });
  std::string told;
  Observer onEnd(logic, {Logic::JobCancelledEvent},
                 [&](unsigned long, void* job) { told = jobOf(job)->GetRecoveryFile(); });

  auto job = startAndReach(parameters, 20);
  scene->Clear(false);
  ASSERT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  const std::string file = job->GetRecoveryFile();
  ASSERT_TRUE(fs::exists(file));
  EXPECT_EQ(told, file); // known when the end is told
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find(file), std::string::npos) << warnings[0];
  ASSERT_EQ(kept().size(), 1u);
  const innergs::RecoveredFit fit = kept()[0];
  EXPECT_EQ(fit.file, fs::path(file));
  EXPECT_EQ(fit.inputs, "Head");
  EXPECT_GE(fit.iteration, 20);
  EXPECT_LT(fit.iteration, kIterations);
  EXPECT_EQ(fit.iterations, kIterations);
  EXPECT_EQ(fit.settings.iterations, kIterations);

  // Going on gives what the uninterrupted fit gave, and needs the file no more.
  parameters = addLongFit();
  parameters->SetResumeFileName(file);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  job = logic->GetLastJob();
  EXPECT_EQ(job->GetNumberOfWarnings(), 0) << job->GetWarning(0);
  const auto resumed = coreOf(job);
  ASSERT_EQ(resumed->field.gaussians.size(), whole->field.gaussians.size());
  EXPECT_EQ(std::memcmp(resumed->field.gaussians.data(), whole->field.gaussians.data(),
                        sizeof(innergs::Gaussian) * whole->field.gaussians.size()),
            0);
  EXPECT_EQ(resumed->field.residual.voxels, whole->field.residual.voxels);
  EXPECT_EQ(parameters->GetResumeFileName(), "");
  EXPECT_TRUE(kept().empty());
}

TEST_F(RecoveryTest, StoppedAgainOneFileStays) {
  auto job = startAndReach(addLongFit(), 20);
  scene->Clear(false);
  const std::string first = job->GetRecoveryFile();
  ASSERT_NE(first, "");
  const int reached = kept()[0].iteration;
  auto* parameters = addLongFit();
  parameters->SetResumeFileName(first);
  job = startAndReach(parameters, reached + 20);
  scene->RemoveNode(parameters); // ends it as well
  ASSERT_TRUE(logic->WaitForJob(job));
  ASSERT_EQ(kept().size(), 1u);
  EXPECT_EQ(kept()[0].file, fs::path(job->GetRecoveryFile()));
  EXPECT_GE(kept()[0].iteration, reached + 20);
}

TEST_F(RecoveryTest, ACompleteFitIsKeptWholeWhileItIsJudged) {
  auto* parameters = addLongFit();
  parameters->SetEvaluateQuality(true);
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  waitUntil([&] {
    logic->ProcessPendingEvents();
    return job->IsDone() || job->IsJudging();
  });
  scene->Clear(false);
  ASSERT_EQ(kept().size(), 1u);
  EXPECT_EQ(kept()[0].iteration, kept()[0].iterations);
  EXPECT_TRUE(innergs::readModel(kept()[0].file).complete());
}

TEST_F(RecoveryTest, TheLogicGoesWhileItRuns) {
  auto* parameters = addLongFit();
  auto other = anotherLogic();
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = other->StartReconstruction(parameters);
  waitUntil([&] {
    other->ProcessPendingEvents();
    return job->GetCurrentIteration() >= 20;
  });
  other = nullptr;
  ASSERT_EQ(kept().size(), 1u);
  EXPECT_GE(kept()[0].iteration, 20);
}

TEST_F(RecoveryTest, CancelKeepsNothing) {
  const auto job = startAndReach(addLongFit(), 20);
  logic->Cancel(job);
  EXPECT_EQ(job->GetRecoveryFile(), "");
  EXPECT_TRUE(kept().empty());
}

TEST_F(RecoveryTest, SaysWhenItCannotBeKept) {
  std::ofstream(folder / "a file") << "x";
  logic->SetRecoveryFolder((folder / "a file").string());
  const auto job = startAndReach(addLongFit(), 20);
  errors.clear();
  scene->Clear(false);
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
  EXPECT_EQ(job->GetRecoveryFile(), "");
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].find("could not be kept"), std::string::npos) << errors[0];
}

// Adding what another scene's file holds, with a parameter set of the same ID among it, ends nothing.
TEST_F(RecoveryTest, ImportingLetsItGoOn) {
  const fs::path file = folder / "other.mrml";
  {
    vtkNew<vtkMRMLScene> another;
    vtkNew<Logic> registers;
    registers->SetMRMLScene(another);
    another->AddNewNodeByClass("vtkMRMLInnerGSParameterNode", "Theirs");
    another->AddNewNodeByClass("vtkMRMLTableNode", "Table");
    another->SetURL(file.string().c_str());
    ASSERT_TRUE(another->Commit());
  }
  auto* parameters = addLongFit();
  const auto job = startAndReach(parameters, 20);
  scene->SetURL(file.string().c_str());
  ASSERT_TRUE(scene->Import());
  EXPECT_EQ(countNodes("vtkMRMLInnerGSParameterNode"), 2);
  EXPECT_FALSE(job->IsDone());
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
  EXPECT_EQ(job->GetParameterNode(), parameters);
  EXPECT_NE(job->GetVolumeNode(), nullptr);
  EXPECT_TRUE(kept().empty());
}

TEST_F(RecoveryTest, AMissingFileIsRefusedBeforeTheStart) {
  auto* parameters = addLongFit();
  parameters->SetResumeFileName((folder / "gone.innergs").string());
  EXPECT_NE(logic->CheckParameters(parameters).find("does not exist"), std::string::npos);
  EXPECT_EQ(logic->StartReconstruction(parameters), nullptr);
}

} // namespace
