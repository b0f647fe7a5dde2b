#pragma once
#include "JobQueue.h"

class vtkSlicerInnerGSLogic;

namespace innergs::mrml {

/// Makes the worker's mail the job's state, the logic's events and, in the end, nodes. On the main thread.
class JobDelivery {
public:
  using ErrorHandler = std::function<void(const std::string&)>;
  JobDelivery(vtkSlicerInnerGSLogic* logic, ErrorHandler onError);

  void deliver(Mail& mail);
  /// Cancelled without an event: nobody is left to hear it.
  static void abandon(vtkSlicerInnerGSJob* job);

private:
  void finish(Task& task);
  void makeNodes(Task& task, vtkMRMLScene* scene);

  vtkSlicerInnerGSLogic* logic_;
  ErrorHandler onError_;
};

} // namespace innergs::mrml
