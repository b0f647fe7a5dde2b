#include "LogicInternals.h"

#include "Core/Acquisition/SliceOrder.h"
#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "IO/FilePath.h"
#include "SliceHeaders.h"

#include <vtkMRMLScalarVolumeNode.h>

#include <algorithm>
#include <utility>

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

bool vtkSlicerInnerGSLogic::Internals::guard(const std::function<void()>& task) {
  const vtkSmartPointer<vtkObject> alive = logic; // an observer of what the task makes may let go of it
  lastError = {};
  try {
    if (std::this_thread::get_id() != mainThread)
      throw Error(
          ErrorCode::InvalidArgument,
          "The InnerGS logic was called from a thread other than the one that made it: call it from the "
          "main thread.");
    task();
    return true;
  } catch (...) {
    fail(innergs::failureOf());
  }
  return false;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Internals::answer(
    vtkMRMLScalarVolumeNode* output, const std::function<vtkSmartPointer<vtkMRMLScalarVolumeNode>()>& make) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  guard([&] {
    made = make();
    if (output) logic->StopFollowing(output);
  });
  return mrml::kept(made, output);
}

void vtkSlicerInnerGSLogic::Internals::fail(const innergs::Failure& failure) {
  const vtkSmartPointer<vtkObject> alive = logic; // an observer may let go of it
  lastError = failure;
  vtkErrorWithObjectMacro(logic, << failure.sentence);
}

void vtkSlicerInnerGSLogic::Internals::stopFollowing(
    const std::function<bool(const mrml::SliceFollower&)>& which) {
  std::erase_if(followers, [&](const auto& follower) {
    const bool ends = which(*follower);
    if (ends) fine.drop(*follower);
    return ends;
  });
}

void vtkSlicerInnerGSLogic::Internals::showFine(const std::shared_ptr<mrml::SliceFollower>& follower,
                                                const mrml::FinePlanes::Plane& plane) {
  const bool followed = std::find(followers.begin(), followers.end(), follower) != followers.end();
  if (!followed) return;
  try {
    follower->show(plane);
  } catch (...) {
    fail(innergs::failureOf());
  }
}

innergs::JobOutline vtkSlicerInnerGSLogic::Internals::outlineOf(vtkMRMLInnerGSParameterNode* parameters) {
  return mrml::outlineOf(parameters, logic->GetMRMLScene(), thicknessOf(), outlineMasks);
}

mrml::ThicknessOf vtkSlicerInnerGSLogic::Internals::thicknessOf() const {
  return [this](vtkMRMLVolumeNode* volume) {
    const double thickness = mrml::dicomSliceThickness(volume, dicom);
    return thickness > 0 ? thickness : mrml::bidsSliceThickness(volume);
  };
}

int vtkSlicerInnerGSLogic::Internals::passesOf(vtkMRMLVolumeNode* volume) const {
  const std::vector<double> times = mrml::dicomSliceTimes(volume, dicom);
  return innergs::interleavedPasses(times.empty() ? mrml::bidsSliceTimes(volume) : times);
}

std::shared_ptr<mrml::Task> vtkSlicerInnerGSLogic::Internals::taskOf(vtkSlicerInnerGSJob* job) const {
  for (const auto& task : queue.tasks())
    if (task->job == job) return task;
  return nullptr;
}

vtkSlicerInnerGSJob*
vtkSlicerInnerGSLogic::Internals::start(const std::function<std::shared_ptr<mrml::Task>()>& prepare) {
  const bool started = this->guard([&] {
    std::shared_ptr<mrml::Task> task = prepare();
    task->recoveryFolder = innergs::pathOf(logic->GetRecoveryFolder());
    const auto job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    job->ParameterNode = task->parameters;
    job->Learning = static_cast<bool>(task->work);
    task->job = job;
    this->queue.submit(std::move(task));
    this->lastJob = job;
  });
  return started ? this->lastJob.Get() : nullptr;
}

bool vtkSlicerInnerGSLogic::Internals::finishes(const vtkSmartPointer<vtkSlicerInnerGSJob>& job) {
  if (!job) return false;
  logic->WaitForJob(job);
  return job->State == vtkSlicerInnerGSJob::Finished;
}
