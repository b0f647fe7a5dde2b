#include "JobDelivery.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "DynamicWork.h"
#include "IO/FilePath.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"
#include "vtkSlicerInnerGSLogic.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>

namespace innergs::mrml {

JobDelivery::JobDelivery(vtkSlicerInnerGSLogic* logic, ErrorHandler onError)
    : logic_(logic), onError_(std::move(onError)) {}

void JobDelivery::deliver(JobUpdate& update) {
  const std::shared_ptr<Task> task = update.task;
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = task->job;
  if (job->IsDone()) return; // abandoned
  if (update.started && job->State == vtkSlicerInnerGSJob::Queued && !task->discard) {
    job->State = vtkSlicerInnerGSJob::Running;
    logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobStartedEvent, job);
  }
  if (update.progress && !task->discard) {
    *job->LastProgress = *update.progress;
    if (const std::string& note = update.progress->note; !note.empty())
      (update.progress->phase == Phase::Predicting ? job->PredictionNote : job->DeviceNote) = note;
    logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobProgressEvent, job);
  }
  if (update.hasPreview() && !task->discard) {
    job->Preview = update.preview;
    job->PreviewIJKToRAS = update.previewToRAS;
    if (update.dynamic) {
      job->PreviewModel = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
      job->PreviewModel->SetField(update.dynamic);
    }
    logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobPreviewEvent, job);
  }
  if (update.done) finish(*task);
}

void JobDelivery::makeNodes(Task& task, vtkMRMLScene* scene) {
  vtkSlicerInnerGSJob* job = task.job;
  if (task.deliver) {
    task.deliver();
    job->ModelNode = task.model;
    return;
  }
  if (task.dynamic) {
    DynamicOutputs made = task.dynamic->makeNodes(scene);
    job->LastProgress->trainingPsnr = task.dynamic->trainingPsnr();
    job->QualityState = task.dynamic->judging();
    job->UsedSettings = task.dynamic->settingsText();
    job->Warnings = std::move(made.warnings);
    job->ModelNode = made.model;
    job->TableNode = made.table;
    job->SequenceNode = made.frames;
    job->BrowserNode = made.browser;
    return;
  }
  job->UsedSettings = task.filter->GetUsedSettings();
  job->AgreementNote = task.filter->GetAgreementNote();
  job->PredictionNote = task.filter->GetPredictionNote();
  job->ProfileNote = task.filter->GetProfileNote();
  job->DeviceNote = task.filter->GetDeviceNote();
  job->UncertaintyNote = task.filter->GetUncertaintyNote();
  job->UncertaintyCoverage = task.filter->GetUncertaintyCoverage();
  job->LastProgress->trainingPsnr = task.filter->GetTrainingPSNR();
  job->LastProgress->heldOutPsnr = task.filter->GetHeldOutPSNR();
  job->NumberOfHeldOutSlices = task.filter->GetNumberOfHeldOutSlices();
  job->QualityState = task.filter->GetQualityState();
  for (int n = 0; n < task.filter->GetNumberOfWarnings(); ++n)
    job->Warnings.push_back(task.filter->GetWarning(n));
  const auto [volume, model, table, slices, uncertainty, measured, replaced, problem] =
      makeOutputs(task, scene);
  if (task.discard) return;
  if (volume) logic_->StopFollowing(volume); // the next move of the view would overwrite the result
  if (uncertainty) logic_->StopFollowing(uncertainty);
  if (replaced)
    job->Warnings.push_back(
        "A chosen output was deleted during the reconstruction: its data are in a new node.");
  if (!problem.empty() && !volume && !model)
    throw Error(ErrorCode::Memory,
                "The fit is complete, but its result could not be put into the scene. " + problem);
  if (!problem.empty())
    job->Warnings.push_back(
        (!volume ? "The volume could not be put into the scene: make it from the model, which is kept. "
                 : "The result could not be put into the scene in full. ") +
        problem);
  else if (!volume || !model)
    job->Warnings.push_back("An output node was deleted as it was made: its data are lost.");
  job->VolumeNode = volume;
  job->ModelNode = model;
  job->TableNode = table;
  job->SliceTableNode = slices;
  if (slices)
    job->Warnings.push_back("The place of every slice is in the table " + quoted(slices.Get()) + ".");
  job->UncertaintyNode = uncertainty;
  job->MeasuredNode = measured;
  if (const vtkSmartPointer<vtkMRMLInnerGSParameterNode> parameters = task.parameters.Get();
      parameters && parameters->GetScene() == scene) {
    using Parameters = vtkMRMLInnerGSParameterNode;
    const auto refer = [&](const char* role, vtkMRMLNode* node) {
      parameters->SetNodeReferenceID(role, node ? node->GetID() : nullptr);
    };
    MRMLNodeModifyBlocker blocker(parameters);
    refer(Parameters::GetResultVolumeReferenceRole(), volume);
    refer(Parameters::GetResultModelReferenceRole(), model);
    refer(Parameters::GetResultTableReferenceRole(), table);
    refer(Parameters::GetResultSliceTableReferenceRole(), slices);
    refer(Parameters::GetResultUncertaintyReferenceRole(), uncertainty);
  }
}

void JobDelivery::finish(Task& task) {
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = task.job;
  job->LastProgress->remaining = 0;
  const vtkSmartPointer<vtkMRMLScene> scene = logic_->GetMRMLScene();
  if (task.discard || task.cancelled || (task.stop.stop_requested() && !task.judging) || !scene ||
      scene != task.scene.Get() || scene->IsClosing()) {
    tellKept(task);
    abandon(job);
    return;
  }
  Failure failure = task.failure;
  if (failure.sentence.empty()) {
    finishing_.push_back(&task);
    try {
      makeNodes(task, scene);
    } catch (...) {
      failure = failureOf();
    }
    std::erase(finishing_, &task);
  }
  if (task.discard)
    tellKept(task);
  else if (failure.sentence.empty())
    forgetResumed(task);
  job->PreviewModel = nullptr;
  task.filter = nullptr; // with its volumes
  task.work = nullptr;
  task.deliver = nullptr;
  task.dynamic = nullptr;
  if (task.discard) {
    abandon(job);
    return;
  }
  if (failure.sentence.empty()) {
    job->LastProgress->fraction = 1;
    job->LastProgress->phase = Phase::Done;
    job->State = vtkSlicerInnerGSJob::Finished;
    logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobFinishedEvent, job);
    return;
  }
  job->State = vtkSlicerInnerGSJob::Failed;
  job->ErrorMessage = failure.sentence;
  job->ErrorCode = vtkInnerGSAlgorithm::ToErrorNumber(failure.code);
  onError_(failure);
  logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobFailedEvent, job);
}

void JobDelivery::tellKept(Task& task) {
  if (task.keep) keepFit(task);
  if (!task.notKept.sentence.empty()) {
    onError_(
        {task.notKept.code, "The state of the reconstruction could not be kept. " + task.notKept.sentence});
    return;
  }
  const RecoveredFit& kept = task.recovered;
  if (kept.file.empty()) return; // it had not begun
  task.job->RecoveryFile = utf8(kept.file);
  if (!task.keep) return; // kept on request, so no warning
  vtkWarningWithObjectMacro(logic_, "The reconstruction of '"
                                        << kept.inputs << "' was stopped at iteration " << kept.iteration
                                        << " of " << kept.iterations << ". Its state is kept in "
                                        << innergs::quoted(kept.file)
                                        << ": load its scans again and continue from that file.");
}

void JobDelivery::forgetResumed(const Task& task) {
  const vtkSmartPointer<vtkMRMLInnerGSParameterNode> parameters = task.parameters.Get();
  if (parameters && task.filter && parameters->GetResumeFileName() == utf8(task.filter->resumeFile))
    parameters->SetResumeFileName("");
  dropResumedFile(task);
}

void JobDelivery::abandon(vtkSlicerInnerGSJob* job, bool tell) {
  if (job->IsDone()) return;
  job->State = vtkSlicerInnerGSJob::Cancelled;
  job->PreviewModel = nullptr;
  if (tell) logic_->InvokeEvent(vtkSlicerInnerGSLogic::JobCancelledEvent, job);
}

void JobDelivery::discard() {
  for (Task* task : finishing_)
    task->discard = task->keep = true;
}

} // namespace innergs::mrml
