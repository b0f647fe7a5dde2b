#pragma once
#include "SegmentationFixture.h"

/// Tests with jobs of the logic.
class JobTest : public MrmlFixture {
protected:
  /// Returns once the worker has finished every job started so far, with nothing delivered yet: another job,
  /// which leaves no trace, then runs.
  void waitForWorker() {
    auto* mask = addNode<vtkMRMLSegmentationNode>();
    mask->GetSegmentation()->SetSourceRepresentationName(kSurface);
    vtkNew<vtkSegment> segment;
    segment->AddRepresentation(kSurface, ballSurface(0, 12));
    mask->GetSegmentation()->AddSegment(segment, "Ball");
    auto* input = addVolume();
    auto* parameters = addParameters(input);
    parameters->SetMaskNode(mask);
    const WatchedRules rules;
    ASSERT_NE(logic->StartReconstruction(parameters), nullptr) << logic->GetLastError();
    WatchedRule::waitForEntry();
    for (vtkMRMLNode* node : {static_cast<vtkMRMLNode*>(parameters), static_cast<vtkMRMLNode*>(input),
                              static_cast<vtkMRMLNode*>(mask)})
      scene->RemoveNode(node);
  }
};

using Logic = vtkSlicerInnerGSLogic;

inline vtkSlicerInnerGSJob* jobOf(void* callData) {
  return static_cast<vtkSlicerInnerGSJob*>(callData);
}
