#include "qSlicerInnerGSMotionHost.h"

#include "Core/Base/NumberText.h"
#include "Core/Motion/TimeSeries.h"
#include "NodeInfo.h"
#include "vtkInnerGSDynamicModel.h"

#include <vtkMRMLApplicationLogic.h>
#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSelectionNode.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkSlicerInnerGSDynamicRequest.h>
#include <vtkSlicerInnerGSJob.h>

#include <vtkImageData.h>
#include <vtkNew.h>

#include <cmath>

using namespace innergs;
using namespace innergs::ui;

namespace {

vtkMRMLSequenceNode* sequenceOf(vtkSlicerInnerGSLogic* logic, const QString& id) {
  return nodeOf<vtkMRMLSequenceNode>(logic ? logic->GetMRMLScene() : nullptr, id);
}

double secondsAt(vtkMRMLSequenceNode* sequence, int item) {
  const std::string unit = sequence->GetIndexUnit();
  const double seconds = unit.empty() ? 1 : secondsOf(unit);
  return seconds * wholeTextNumber(sequence->GetNthIndexValue(item)).value_or(NAN);
}

} // namespace

qSlicerInnerGSMotionHost::qSlicerInnerGSMotionHost(QObject* parent) : MotionHost(parent) {
  frame_.setSingleShot(true);
  frame_.setInterval(0);
  connect(&frame_, &QTimer::timeout, this, &qSlicerInnerGSMotionHost::showFrame);
  previewFrame_.setSingleShot(true);
  previewFrame_.setInterval(0);
  connect(&previewFrame_, &QTimer::timeout, this, &qSlicerInnerGSMotionHost::showPreview);
}

void qSlicerInnerGSMotionHost::setLogic(vtkSlicerInnerGSLogic* logic) {
  logicObservers_.clear();
  logic_ = logic;
  logicObservers_.add(logic,
                      {vtkSlicerInnerGSLogic::JobProgressEvent, vtkSlicerInnerGSLogic::JobPreviewEvent,
                       vtkSlicerInnerGSLogic::JobFinishedEvent, vtkSlicerInnerGSLogic::JobFailedEvent,
                       vtkSlicerInnerGSLogic::JobCancelledEvent},
                      this, &qSlicerInnerGSMotionHost::onJob);
}

vtkMRMLInnerGSModelNode* qSlicerInnerGSMotionHost::modelNode(const QString& id) const {
  auto* node = nodeOf<vtkMRMLInnerGSModelNode>(logic_ ? logic_->GetMRMLScene() : nullptr, id);
  return node && node->IsDynamic() ? node : nullptr;
}

SeriesInfo qSlicerInnerGSMotionHost::seriesInfo(const QString& id) const {
  SeriesInfo info;
  vtkMRMLSequenceNode* sequence = sequenceOf(logic_, id);
  if (!sequence) return info;
  info.name = QString::fromUtf8(sequence->GetName());
  info.frames = sequence->GetNumberOfDataNodes();
  if (auto* first = vtkMRMLVolumeNode::SafeDownCast(sequence->GetNthDataNode(0));
      first && first->GetImageData())
    first->GetImageData()->GetDimensions(info.dimensions.data());
  vtkNew<vtkSlicerInnerGSDynamicRequest> request;
  request->SetSeries(sequence);
  info.timed = logic_->CheckDynamicRequest(request).empty();
  if (info.timed) {
    info.first = secondsAt(sequence, 0);
    info.last = secondsAt(sequence, info.frames - 1);
  } else {
    request->SetInterval(1); // a problem that remains is more than missing times
    info.problem = QString::fromStdString(logic_->CheckDynamicRequest(request));
  }
  return info;
}

bool qSlicerInnerGSMotionHost::start(const MotionRequest& request) {
  if (!logic_) {
    Q_EMIT failed(tr("The InnerGS module is not completely loaded: restart Slicer."));
    return false;
  }
  if (isRunning()) {
    Q_EMIT failed(tr("A reconstruction is running: wait for it or cancel it."));
    return false;
  }
  vtkNew<vtkSlicerInnerGSDynamicRequest> asked;
  asked->SetSeries(sequenceOf(logic_, request.seriesId));
  asked->SetInterval(request.interval);
  asked->SetSettings(request.settings);
  asked->SetRate(request.rate);
  asked->SetEvaluateQuality(request.evaluateQuality);
  asked->SetSliceTimingFileName(request.sliceTimesFile.toStdString());
  asked->SetResumeFileName(request.resumeFile.toStdString());
  asked->KeepWhenCancelledOn();
  job_ = logic_->StartDynamicReconstruction(asked);
  if (!job_) {
    Q_EMIT failed(QString::fromStdString(logic_->GetLastError()));
    return false;
  }
  preview_ = nullptr;
  previewTime_ = NAN;
  scan_ = seriesInfo(request.seriesId).name;
  Q_EMIT started();
  return true;
}

void qSlicerInnerGSMotionHost::cancel() {
  if (logic_ && job_) logic_->RequestCancel(job_);
}

bool qSlicerInnerGSMotionHost::isRunning() const {
  return job_ && !job_->IsDone();
}

void qSlicerInnerGSMotionHost::onJob(vtkObject*, unsigned long event, void* data) {
  if (!job_ || data != job_.Get()) return; // another's
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = job_;
  if (event == vtkSlicerInnerGSLogic::JobProgressEvent) {
    Q_EMIT progressed(job->GetProgressReport());
    return;
  }
  if (event == vtkSlicerInnerGSLogic::JobPreviewEvent) {
    double range[2];
    if (!job->GetPreviewModel() || !job->GetPreviewModel()->GetTimeRange(range)) return;
    if (std::isnan(previewTime_)) previewTime_ = range[0];
    previewFrame_.start();
    Q_EMIT previewed();
    return;
  }
  job_ = nullptr;
  previewFrame_.stop();
  if (event != vtkSlicerInnerGSLogic::JobFinishedEvent) dropPreview();
  if (event == vtkSlicerInnerGSLogic::JobFailedEvent) {
    Q_EMIT failed(QString::fromStdString(job->GetErrorMessage()));
    return;
  }
  if (event == vtkSlicerInnerGSLogic::JobCancelledEvent) {
    Q_EMIT cancelled();
    return;
  }
  MotionReport report;
  vtkMRMLInnerGSModelNode* model = job->GetModelNode();
  for (int n = 0; n < job->GetNumberOfWarnings(); ++n)
    report.warnings << QString::fromStdString(job->GetWarning(n));
  report.quality = qualityOf(job->GetTableNode(), report.samples);
  report.seconds = job->GetElapsedSeconds();
  if (model) {
    report.modelId = QString::fromUtf8(model->GetID());
    report.gaussians = model->GetDynamicModel()->GetNumberOfGaussians();
    if (preview_) { // it goes on showing the model, at the same time
      shown_ = preview_;
      shownOf_ = report.modelId;
      setTime(report.modelId, previewTime_);
    } else {
      setTime(report.modelId, model->GetTime());
    }
  } else {
    dropPreview();
  }
  Q_EMIT finished(report);
}

MotionInfo qSlicerInnerGSMotionHost::motionInfo(const QString& modelId) const {
  vtkMRMLInnerGSModelNode* node = modelNode(modelId);
  return node ? motionInfoOf(node->GetDynamicModel(), node->GetTime()) : MotionInfo();
}

MotionInfo qSlicerInnerGSMotionHost::previewInfo() const {
  return motionInfoOf(job_ ? job_->GetPreviewModel() : nullptr, previewTime_);
}

void qSlicerInnerGSMotionHost::setPreviewTime(double seconds) {
  previewTime_ = seconds;
  previewFrame_.start();
}

/// The model so far at its time, in all slice views the first time.
void qSlicerInnerGSMotionHost::showPreview() {
  if (!logic_ || !job_ || !job_->GetPreviewModel()) return;
  vtkMRMLScalarVolumeNode* before = preview_;
  vtkMRMLScalarVolumeNode* volume = logic_->PreviewFrame(job_, previewTime_, before);
  if (!volume) return; // the logic has said why
  preview_ = volume;
  if (!before) putIntoViews(volume, tr("%1 InnerGS model in time").arg(scan_).toStdString());
}

/// After a fit that gave no model.
void qSlicerInnerGSMotionHost::dropPreview() {
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> volume = preview_.GetPointer();
  preview_ = nullptr;
  if (volume && volume->GetScene() && !volume->GetScene()->IsClosing())
    volume->GetScene()->RemoveNode(volume);
}

/// The browser of the frames made from the model; null: none.
vtkMRMLSequenceBrowserNode* qSlicerInnerGSMotionHost::browserOf(vtkMRMLInnerGSModelNode* model) const {
  std::vector<vtkMRMLNode*> browsers;
  model->GetScene()->GetNodesByClass("vtkMRMLSequenceBrowserNode", browsers);
  for (vtkMRMLNode* node : browsers) {
    auto* browser = vtkMRMLSequenceBrowserNode::SafeDownCast(node);
    std::vector<vtkMRMLSequenceNode*> sequences;
    browser->GetSynchronizedSequenceNodes(sequences, true);
    for (vtkMRMLSequenceNode* sequence : sequences)
      if (sequence && sequence->GetNodeReference("InnerGSModel") == model && browser->GetMasterSequenceNode())
        return browser;
  }
  return nullptr;
}

void qSlicerInnerGSMotionHost::watch(const QString& modelId) {
  if (modelId == watched_) return;
  browserObservers_.clear();
  watched_ = modelId;
  selected_ = -1;
  vtkMRMLInnerGSModelNode* node = modelNode(modelId);
  vtkMRMLSequenceBrowserNode* browser = node ? browserOf(node) : nullptr;
  if (!browser) return;
  selected_ = browser->GetSelectedItemNumber();
  browserObservers_.add(browser, {vtkCommand::ModifiedEvent}, this, &qSlicerInnerGSMotionHost::onBrowser);
}

void qSlicerInnerGSMotionHost::onBrowser(vtkObject* caller, unsigned long, void*) {
  auto* browser = vtkMRMLSequenceBrowserNode::SafeDownCast(caller);
  const int item = browser ? browser->GetSelectedItemNumber() : -1;
  vtkMRMLInnerGSModelNode* node = modelNode(watched_);
  if (!node || item < 0 || item == selected_) return;
  selected_ = item;
  vtkMRMLSequenceNode* sequence = browser->GetMasterSequenceNode();
  const double time = sequence ? secondsAt(sequence, item) : NAN;
  if (!std::isfinite(time)) return;
  node->SetTime(time);
  frame_.start();
  Q_EMIT timeChanged(watched_, node->GetTime());
}

void qSlicerInnerGSMotionHost::setTime(const QString& modelId, double seconds) {
  vtkMRMLInnerGSModelNode* node = modelNode(modelId);
  if (!node) return;
  watch(modelId);
  node->SetTime(seconds);
  frame_.start();
  vtkMRMLSequenceBrowserNode* browser = browserOf(node);
  vtkMRMLSequenceNode* sequence = browser ? browser->GetMasterSequenceNode() : nullptr;
  if (!sequence) return;
  int nearest = -1;
  double least = INFINITY;
  for (int item = 0; item < sequence->GetNumberOfDataNodes(); ++item)
    if (const double away = std::abs(secondsAt(sequence, item) - seconds); away < least) {
      least = away;
      nearest = item;
    }
  if (nearest < 0 || nearest == selected_) return;
  selected_ = nearest; // so that it does not come back as the browser's own choice
  browser->SetSelectedItemNumber(nearest);
}

/// The model at its time as a volume, in all slice views the first time.
void qSlicerInnerGSMotionHost::showFrame() {
  vtkMRMLInnerGSModelNode* node = modelNode(watched_);
  if (!node) return;
  vtkMRMLScalarVolumeNode* before = shownOf_ == watched_ ? shown_.Get() : nullptr;
  vtkMRMLScalarVolumeNode* volume = logic_->Resample(node, 0, before);
  if (!volume) return; // the logic has said why
  shownOf_ = watched_;
  shown_ = volume;
  if (before) return;
  putIntoViews(volume, std::string(node->GetName()) + " in time");
}

void qSlicerInnerGSMotionHost::putIntoViews(vtkMRMLScalarVolumeNode* volume, const std::string& name) {
  volume->SetName(volume->GetScene()->GenerateUniqueName(name).c_str());
  vtkMRMLApplicationLogic* application = logic_->GetMRMLApplicationLogic();
  vtkMRMLSelectionNode* selection = application ? application->GetSelectionNode() : nullptr;
  if (!selection) return;
  selection->SetActiveVolumeID(volume->GetID());
  application->PropagateVolumeSelection();
}

QString qSlicerInnerGSMotionHost::saveFrames(const QString&, double, const QString&) {
  return tr("Save the sequence of frames with Slicer's own File, Save.");
}
