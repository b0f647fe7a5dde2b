#pragma once
#include "JobQueue.h"

class vtkSlicerInnerGSLogic;

namespace innergs::mrml {

/// Makes the worker's update the job's state, the logic's events and, in the end, nodes. On the main thread.
class JobDelivery {
public:
  using ErrorHandler = std::function<void(const Failure&)>;
  JobDelivery(vtkSlicerInnerGSLogic* logic, ErrorHandler onError);

  void deliver(JobUpdate& update);
  /// Cancelled at once, whatever update is still to come.
  void abandon(vtkSlicerInnerGSJob* job, bool tell = true);
  /// What is being made into nodes is not wanted any more: the scene goes.
  void discard();

private:
  void finish(Task& task);
  void makeNodes(Task& task, vtkMRMLScene* scene);

  vtkSlicerInnerGSLogic* logic_;
  ErrorHandler onError_;
  std::vector<Task*> finishing_; // several when an observer of one's nodes waits for another's
};

} // namespace innergs::mrml
