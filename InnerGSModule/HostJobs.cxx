#include "Core/Base/Failure.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/Progress.h"
#include "NodeInfo.h"
#include "qSlicerInnerGSHost.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScene.h>
#include <vtkSlicerInnerGSJob.h>
#include <vtkSlicerInnerGSLogic.h>

/// The host's part about reconstructions.

using namespace innergs;
using namespace innergs::ui;

Estimate qSlicerInnerGSHost::estimate(const Request& request) {
  Estimate estimate;
  if (!active_) return estimate;
  if (!logic_ || !parameters_) {
    estimate.refusal = tr("There is no parameter set: choose or create one above.");
    return estimate;
  }
  store(request);
  estimate.refusal = QString::fromStdString(logic_->CheckParameters(parameters_));
  estimate.memory = logic_->EstimateMemory(parameters_); // 0 where that is not why it is refused
  estimate.available = availableMemory();
  if (!estimate.refusal.isEmpty()) return estimate;
  fillSlowly(estimate);
  return estimate;
}

/// A small fit is timed, and a device loaded, on a thread; estimateChanged() follows.
void qSlicerInnerGSHost::fillSlowly(Estimate& estimate) {
  std::string key;
  const auto later = logic_->EstimateLater(parameters_, &key);
  const QString known = QString::fromStdString(key);
  if (const auto found = slow_.constFind(known); found != slow_.constEnd()) {
    estimate.seconds = found->seconds;
    estimate.reason = QString::fromStdString(found->device);
    estimate.refusal = QString::fromStdString(found->refusal);
    return;
  }
  if (!later || estimating_ || isRunning()) return; // then, a time measured says nothing
  estimating_ = true;
  run([this, later, known]() -> std::function<void()> {
    vtkSlicerInnerGSLogic::SlowEstimate found;
    const std::string problem = sentenceOf([&] { found = later(); });
    if (!problem.empty()) found.device = problem;
    return [this, found, known] {
      estimating_ = false;
      slow_.insert(known, found);
      Q_EMIT estimateChanged();
    };
  });
}

bool qSlicerInnerGSHost::start(const Request& request) {
  if (isRunning()) {
    Q_EMIT failed(tr("A reconstruction is running: wait for its end or cancel it."));
    return false;
  }
  if (!logic_ || !parameters_) {
    Q_EMIT failed(tr("There is no parameter set: choose or create one above."));
    return false;
  }
  store(request);
  job_ = logic_->StartReconstruction(parameters_, false);
  if (!job_) {
    Q_EMIT failed(lastError());
    return false;
  }
  phase_.reset();
  deviceNote_.clear();
  cancelling_ = false;
  Q_EMIT started();
  if (isQueued()) {
    Q_EMIT waiting();
    Q_EMIT logged(tr("Waiting for another reconstruction to end."));
  }
  return true;
}

/// What ended a job that nobody cancelled, a sentence; "" else.
QString qSlicerInnerGSHost::whyEnded(vtkSlicerInnerGSJob* job) const {
  if (cancelling_) return {};
  if (!scene_ || scene_->IsClosing()) return tr("The scene was closed, which ended the reconstruction.");
  vtkMRMLInnerGSParameterNode* parameters = job->GetParameterNode();
  return parameters && parameters->GetScene() == scene_
             ? QString()
             : tr("Its parameter set was deleted, which ended the reconstruction.");
}

void qSlicerInnerGSHost::cancel() {
  cancelling_ = true;
  if (logic_ && job_) logic_->RequestCancel(job_);
}

/// Behind another job, a script's.
bool qSlicerInnerGSHost::isQueued() const {
  return job_ && job_->GetState() == vtkSlicerInnerGSJob::Queued && logic_ && logic_->GetCurrentJob() != job_;
}

bool qSlicerInnerGSHost::isRunning() const {
  return job_ && !job_->IsDone();
}

void qSlicerInnerGSHost::onJob(vtkObject*, unsigned long event, void* data) {
  if (!job_ || data != job_.Get()) return; // a script's
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = job_;
  switch (event) {
  case vtkSlicerInnerGSLogic::JobStartedEvent: // no longer waiting
    Q_EMIT progressed(Progress{Phase::Preparing});
    return;
  case vtkSlicerInnerGSLogic::JobProgressEvent: {
    Progress progress = job->GetProgressReport();
    if (progress.phase != phase_) Q_EMIT logged(QString::fromStdString(job->GetDescription()));
    phase_ = progress.phase;
    progress.note.clear();
    if (const std::string note = job->GetDeviceNote(); note != deviceNote_)
      progress.note = deviceNote_ = note; // once
    Q_EMIT progressed(progress);
    return;
  }
  case vtkSlicerInnerGSLogic::JobPreviewEvent:
    Q_EMIT previewed(job->GetPreviewImage(), job->GetPreviewIJKToRASMatrix());
    return;
  default:
    break;
  }
  job_ = nullptr;
  slow_.clear(); // a fit on a device tells how long others take there
  if (event == vtkSlicerInnerGSLogic::JobFinishedEvent) {
    const Report report = reportOf(job);
    watchModels();
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
    Q_EMIT finished(report);
  } else if (event == vtkSlicerInnerGSLogic::JobFailedEvent) {
    Q_EMIT failed(QString::fromStdString(job->GetErrorMessage()));
  } else if (const QString why = whyEnded(job); !why.isEmpty()) {
    Q_EMIT failed(why);
  } else {
    Q_EMIT cancelled();
  }
}
