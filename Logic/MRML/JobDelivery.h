#pragma once
#include "JobQueue.h"

class vtkSlicerInnerGSLogic;

namespace innergs::mrml {

/// Turns the worker's updates into the job's state, the logic's events and, at the end, nodes. Main thread.
class JobDelivery {
public:
  using ErrorHandler = std::function<void(const Failure&)>;
  JobDelivery(vtkSlicerInnerGSLogic* logic, ErrorHandler onError);

  void deliver(JobUpdate& update);
  /// Cancels at once, whatever updates are still to come.
  void abandon(vtkSlicerInnerGSJob* job, bool tell = true);
  /// Drops what is being made into nodes: the scene is closing.
  void discard();

private:
  void finish(Task& task);
  void makeNodes(Task& task, vtkMRMLScene* scene);
  void tellKept(Task& task);
  /// Forgets and removes the file that the task continued: the fit is complete.
  static void forgetResumed(const Task& task);

  vtkSlicerInnerGSLogic* logic_;
  ErrorHandler onError_;
  std::vector<Task*> finishing_; // several if an observer of one task's nodes waits for another task
};

} // namespace innergs::mrml
