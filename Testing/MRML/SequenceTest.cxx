#include "MrmlFixture.h"

#include <vtkMRMLSliceNode.h>

#include <vtkTransform.h>

#include <random>

namespace {

using SequenceTest = MrmlFixture;

/// Any actions of a user in any order: nothing crashes, every job ends once, and the logic keeps working.
TEST_F(SequenceTest, AnyOrderOfActions) {
  using Logic = vtkSlicerInnerGSLogic;
  int started = 0, ended = 0;
  Observer watch(logic, {Logic::JobFinishedEvent, Logic::JobFailedEvent, Logic::JobCancelledEvent},
                 [&](unsigned long, void*) { ++ended; });
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937 random(seed);
    const auto pick = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
    const auto anyNode = [&](const char* className) -> vtkMRMLNode* {
      const int count = countNodes(className);
      return count ? scene->GetNthNodeByClass(pick(count), className) : nullptr;
    };
    const auto anyParameters = [&] {
      return vtkMRMLInnerGSParameterNode::SafeDownCast(anyNode("vtkMRMLInnerGSParameterNode"));
    };
    const auto anyModel = [&] {
      return vtkMRMLInnerGSModelNode::SafeDownCast(anyNode("vtkMRMLInnerGSModelNode"));
    };
    const auto anyVolume = [&] {
      return vtkMRMLScalarVolumeNode::SafeDownCast(anyNode("vtkMRMLScalarVolumeNode"));
    };
    for (int step = 0; step < 150; ++step) {
      switch (pick(16)) {
      case 0:
      case 1: {
        auto* parameters = addParameters(addVolume());
        parameters->SetNumberOfIterations(pick(3) ? 5 : 100000);
        started += logic->StartReconstruction(parameters) != nullptr;
        break;
      }
      case 2:
        started += logic->StartReconstruction(anyParameters()) != nullptr;
        break;
      case 3:
        logic->Cancel(logic->GetCurrentJob());
        break;
      case 4:
        logic->Cancel(logic->GetLastJob());
        break;
      case 5:
      case 6:
        logic->WaitForJob(nullptr, 0.01 * pick(5));
        break;
      case 7:
        logic->ProcessPendingEvents();
        break;
      case 8:
        if (auto* node = anyVolume()) scene->RemoveNode(node);
        break;
      case 9:
        if (auto* node = pick(2) ? static_cast<vtkMRMLNode*>(anyParameters()) : anyModel())
          scene->RemoveNode(node);
        break;
      case 10:
        if (pick(4) == 0) scene->Clear(false);
        break;
      case 11:
        logic->GetValueAtRAS(anyModel(), 1, 2, 3);
        break;
      case 12: {
        auto* slice = vtkMRMLSliceNode::SafeDownCast(anyNode("vtkMRMLSliceNode"));
        if (!slice) {
          slice = addNode<vtkMRMLSliceNode>();
          slice->SetLayoutName("Red");
        }
        logic->FollowSlice(anyModel(), slice, pick(2) ? anyVolume() : nullptr);
        slice->SetSliceOffset(pick(10));
        break;
      }
      case 13:
        if (auto* parameters = anyParameters()) {
          parameters->SetOutputVolumeNode(anyVolume());
          parameters->SetOutputModelNode(pick(2) ? anyModel() : nullptr);
        }
        break;
      case 14:
        if (auto* node = anyVolume()) {
          vtkNew<vtkTransform> turn;
          turn->RotateX(pick(40));
          node->SetAndObserveTransformNodeID(addTransform(turn->GetMatrix())->GetID());
        }
        break;
      default:
        logic->Resample(anyModel(), 4, pick(2) ? anyVolume() : nullptr);
      }
    }
    logic->Cancel();
    EXPECT_EQ(logic->GetNumberOfJobs(), 0);
    EXPECT_EQ(ended, started) << "seed " << seed;
    scene->Clear(false);
  }
  EXPECT_GT(started, 40);
  EXPECT_TRUE(logic->Reconstruct(addParameters(addVolume()))) << logic->GetLastError();
}

} // namespace
