#include "JobFixture.h"
#include "vtkInnerGSAlgorithm.h"

#include <new>

namespace {

bool isA(void* node, const char* className) {
  return static_cast<vtkMRMLNode*>(node)->IsA(className);
}

std::string warningsOf(vtkSlicerInnerGSJob* job) {
  std::string all;
  for (int n = 0; n < job->GetNumberOfWarnings(); ++n)
    all += job->GetWarning(n) + "\n";
  return all;
}

// Observers of a new node may exhaust the memory: the rest of a finished fit is kept.
TEST_F(JobTest, MemoryEndsWhileOutputsAreMade) {
  for (const char* className : {"vtkMRMLScalarVolumeNode", "vtkMRMLScalarVolumeDisplayNode",
                                "vtkMRMLInnerGSModelNode", "vtkMRMLTableNode"})
    for (const unsigned long event : {vtkMRMLScene::NodeAboutToBeAddedEvent, vtkMRMLScene::NodeAddedEvent}) {
      SCOPED_TRACE(className);
      auto* parameters = addParameters(addVolume());
      parameters->SetNumberOfIterations(20);
      parameters->SetEvaluateQuality(true);
      vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
      ASSERT_NE(job, nullptr) << logic->GetLastError();
      bool thrown = false;
      Observer watch(scene, {event}, [&](unsigned long, void* node) {
        if (thrown || !isA(node, className)) return;
        thrown = true;
        throw std::bad_alloc();
      });
      ASSERT_TRUE(logic->WaitForJob(job, 60));
      EXPECT_TRUE(thrown);
      ASSERT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
      ASSERT_NE(job->GetModelNode(), nullptr);
      EXPECT_EQ(job->GetModelNode()->GetScene(), scene.Get());
      EXPECT_NEAR(logic->GetValueAtRAS(job->GetModelNode(), 0, 0, 0), truth(0, 0, 0), 15);
      EXPECT_NE(warningsOf(job).find("There is not enough memory: "), std::string::npos) << warningsOf(job);
      EXPECT_EQ(warningsOf(job).find("bad_alloc"), std::string::npos);
      ASSERT_NE(job->GetVolumeNode(), nullptr);
      EXPECT_EQ(job->GetVolumeNode()->GetNodeReference("InnerGSModel"), job->GetModelNode());
      EXPECT_LT(error(job->GetVolumeNode()), 15);
      scene->Clear(false);
    }
}

TEST_F(JobTest, FailsWithASentenceWhereNoOutputCanBeMade) {
  auto* parameters = addParameters(addVolume());
  parameters->SetNumberOfIterations(2);
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr);
  Observer watch(scene, {vtkMRMLScene::NodeAboutToBeAddedEvent},
                 [&](unsigned long, void*) { throw std::bad_alloc(); });
  ASSERT_TRUE(logic->WaitForJob(job, 60));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_EQ(job->GetErrorCode(), vtkInnerGSAlgorithm::MemoryError) << job->GetErrorMessage();
  EXPECT_NE(job->GetErrorMessage().find("The fit is complete"), std::string::npos) << job->GetErrorMessage();
}

} // namespace
