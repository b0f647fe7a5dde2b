#pragma once
#include "SegmentationFixture.h"

/// Jobs of the logic.
class JobTest : public MrmlFixture {
protected:
  /// Returns when the worker is through with every job started so far, nothing of which is delivered yet:
  /// another job, gone without a trace, has its turn then.
  void waitForWorker() {
    auto* mask = vtkMRMLSegmentationNode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLSegmentationNode"));
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
