#include "qSlicerInnerGSHost.h"

#include "Core/ReconstructionJob.h"
#include "NodeInfo.h"
#include "ParameterRequest.h"
#include "qSlicerInnerGSSelector.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>
#include <vtkSlicerInnerGSJob.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <QDir>
#include <QRunnable>
#include <QSettings>

#include <utility>

using namespace innergs;
using namespace innergs::ui;

namespace {

constexpr const char* kFolder = "InnerGS/Folder";

Phase knownPhase(const std::string& name, Phase otherwise) {
  for (const Phase known : {Phase::Preparing, Phase::Initialising, Phase::Fitting, Phase::Refining,
                            Phase::Rendering, Phase::Done})
    if (name == phaseName(known)) return known;
  return otherwise;
}

Progress progressOf(vtkSlicerInnerGSJob* job) {
  Progress progress;
  const std::string phase = job->GetPhase();
  progress.phase = Phase::Refining; // what is judged has phases of its own
  for (const Phase known : {Phase::Preparing, Phase::Initialising, Phase::Fitting, Phase::Refining,
                            Phase::Rendering, Phase::Done})
    if (phase == phaseName(known)) progress.phase = known;
  progress.fraction = job->GetProgress();
  progress.iteration = job->GetCurrentIteration();
  progress.iterations = job->GetTotalIterations();
  progress.loss = job->GetLoss();
  progress.trainingPsnr = job->GetTrainingPSNR();
  progress.heldOutPsnr = job->GetHeldOutPSNR();
  progress.gaussians = job->GetNumberOfGaussians();
  progress.elapsed = job->GetElapsedSeconds();
  progress.remaining = job->GetRemainingSeconds();
  return progress;
}

} // namespace

qSlicerInnerGSHost::qSlicerInnerGSHost(QObject* parent) : Host(parent) {
  qRegisterMetaType<Progress>("innergs::Progress");
  qRegisterMetaType<Report>("innergs::ui::Report");
  changed_.setSingleShot(true);
  changed_.setInterval(0);
  connect(&changed_, &QTimer::timeout, this, [this] {
    if (scene_ && (scene_->IsClosing() || scene_->IsImporting() || scene_->IsBatchProcessing())) return;
    watchModels();
    watchVolumes();
    volumesBefore_ = volumesNow();
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
    for (const QString& id : std::exchange(remade_, {})) {
      vtkMRMLInnerGSModelNode* node = modelNode(id);
      vtkMRMLModelNode* ellipsoids = node ? ellipsoidsOf(node) : nullptr;
      if (ellipsoidsWanted_.contains(id) || (ellipsoids && ellipsoids->GetDisplayVisibility()))
        showEllipsoids(id, true); // of the new model
    }
  });
  modelsMoved_.setSingleShot(true);
  modelsMoved_.setInterval(150);
  connect(&modelsMoved_, &QTimer::timeout, this, &Host::modelsChanged);
  volumesEdited_.setSingleShot(true);
  volumesEdited_.setInterval(150);
  connect(&volumesEdited_, &QTimer::timeout, this, [this] {
    const QString now = volumesNow();
    if (now == std::exchange(volumesBefore_, now)) return;
    Q_EMIT volumesChanged();
    Q_EMIT estimateChanged();
  });
  threads_.setMaxThreadCount(1);
}

qSlicerInnerGSHost::~qSlicerInnerGSHost() {
  threads_.clear();
  threads_.waitForDone();
  for (auto* list : {&logicWatches_, &sceneWatches_, &modelWatches_, &volumeWatches_})
    unwatch(*list);
}

template <class Method>
void qSlicerInnerGSHost::watch(std::vector<Watch>& list, vtkObject* object, unsigned long event, Method m) {
  list.push_back({object, object->AddObserver(event, this, m)});
}

void qSlicerInnerGSHost::unwatch(std::vector<Watch>& list) {
  for (const Watch& watch : list)
    if (watch.object) watch.object->RemoveObserver(watch.tag);
  list.clear();
}

void qSlicerInnerGSHost::setLogic(vtkSlicerInnerGSLogic* logic) {
  unwatch(logicWatches_);
  logic_ = logic;
  if (!logic) return;
  for (const unsigned long event :
       {vtkSlicerInnerGSLogic::JobProgressEvent, vtkSlicerInnerGSLogic::JobPreviewEvent,
        vtkSlicerInnerGSLogic::JobFinishedEvent, vtkSlicerInnerGSLogic::JobFailedEvent,
        vtkSlicerInnerGSLogic::JobCancelledEvent})
    watch(logicWatches_, logic, event, &qSlicerInnerGSHost::onJob);
}

void qSlicerInnerGSHost::setMRMLScene(vtkMRMLScene* scene) {
  if (scene == scene_) return;
  unwatch(sceneWatches_);
  unwatch(modelWatches_);
  unwatch(volumeWatches_);
  moved_.clear();
  scene_ = scene;
  if (scene)
    for (const unsigned long event :
         {vtkMRMLScene::NodeAddedEvent, vtkMRMLScene::NodeRemovedEvent, vtkMRMLScene::EndBatchProcessEvent,
          vtkMRMLScene::EndImportEvent, vtkMRMLScene::EndCloseEvent})
      watch(sceneWatches_, scene, event, &qSlicerInnerGSHost::onScene);
  Q_EMIT mrmlSceneChanged(scene);
  changed_.start();
}

void qSlicerInnerGSHost::setParameterNode(vtkMRMLInnerGSParameterNode* node) {
  parameters_ = node;
}

vtkMRMLInnerGSParameterNode* qSlicerInnerGSHost::parameterNode() const {
  return parameters_;
}

void qSlicerInnerGSHost::setActive(bool active) {
  active_ = active;
}

void qSlicerInnerGSHost::store(const Request& request) {
  if (!active_ || !parameters_ || !scene_ || scene_->IsClosing() || scene_->IsImporting()) return;
  setRequest(parameters_, request);
}

vtkMRMLInnerGSModelNode* qSlicerInnerGSHost::modelNode(const QString& id) const {
  return scene_ && !id.isEmpty()
             ? vtkMRMLInnerGSModelNode::SafeDownCast(scene_->GetNodeByID(id.toUtf8().constData()))
             : nullptr;
}

QString qSlicerInnerGSHost::lastError() const {
  return logic_ ? QString::fromStdString(logic_->GetLastError())
                : tr("The InnerGS module is not loaded completely: restart Slicer.");
}

//------------------------------------------------------------------------------ scene

void qSlicerInnerGSHost::onScene(vtkObject*, unsigned long, void*) {
  changed_.start();
}

void qSlicerInnerGSHost::onModel(vtkObject* caller, unsigned long event, void*) {
  if (event == vtkMRMLTransformableNode::TransformModifiedEvent) {
    modelsMoved_.start();
    return;
  }
  if (event == vtkMRMLInnerGSModelNode::ModelModifiedEvent)
    remade_.insert(idOf(vtkMRMLNode::SafeDownCast(caller)));
  if (!changed_.isActive()) changed_.start();
}

void qSlicerInnerGSHost::onVolume(vtkObject*, unsigned long, void*) {
  if (!volumesEdited_.isActive()) volumesEdited_.start();
}

void qSlicerInnerGSHost::watchVolumes() {
  unwatch(volumeWatches_);
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLVolumeNode", nodes);
  for (vtkMRMLNode* node : nodes)
    for (const unsigned long event :
         {static_cast<unsigned long>(vtkCommand::ModifiedEvent),
          static_cast<unsigned long>(vtkMRMLVolumeNode::ImageDataModifiedEvent),
          static_cast<unsigned long>(vtkMRMLTransformableNode::TransformModifiedEvent)})
      watch(volumeWatches_, node, event, &qSlicerInnerGSHost::onVolume);
}

/// What the panels know of the volumes, without their voxels.
QString qSlicerInnerGSHost::volumesNow() const {
  QString text;
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLVolumeNode", nodes);
  for (vtkMRMLNode* node : nodes) {
    auto* volume = vtkMRMLVolumeNode::SafeDownCast(node);
    if (volume->GetNodeReferenceID("InnerGSModel")) continue; // made here, some at each move of a view
    text += idOf(node) + QChar('\n') + QString::fromUtf8(node->GetName()) + QChar('\n') +
            QString::fromUtf8(volume->GetTransformNodeID());
    vtkNew<vtkMatrix4x4> matrix;
    volume->GetIJKToRASMatrix(matrix);
    vtkNew<vtkMatrix4x4> toWorld;
    if (vtkMRMLTransformNode* parent = volume->GetParentTransformNode())
      text += QString::number(parent->GetMatrixTransformToWorld(toWorld));
    vtkMatrix4x4::Multiply4x4(toWorld, matrix, matrix);
    for (int i = 0; i < 16; ++i)
      text += QStringLiteral(" %1").arg(matrix->GetData()[i]);
    int size[3] = {0, 0, 0};
    if (volume->GetImageData()) volume->GetImageData()->GetDimensions(size);
    for (const int n : size)
      text += QStringLiteral(" %1").arg(n);
  }
  return text;
}

/// `work` on a thread, and then what it returns here, while this lives.
void qSlicerInnerGSHost::run(const std::function<std::function<void()>()>& work) {
  struct Runnable : QRunnable {
    std::function<void()> call;
    void run() override { call(); }
  };
  auto* runnable = new Runnable;
  runnable->call = [this, work] { QMetaObject::invokeMethod(this, work(), Qt::QueuedConnection); };
  threads_.start(runnable);
}

void qSlicerInnerGSHost::watchModels() {
  unwatch(modelWatches_);
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLInnerGSModelNode", nodes);
  for (vtkMRMLNode* node : nodes)
    for (const unsigned long event :
         {static_cast<unsigned long>(vtkCommand::ModifiedEvent),
          static_cast<unsigned long>(vtkMRMLInnerGSModelNode::ModelModifiedEvent),
          static_cast<unsigned long>(vtkMRMLTransformableNode::TransformModifiedEvent)})
      watch(modelWatches_, node, event, &qSlicerInnerGSHost::onModel);
  for (const QString& id : moved_.keys())
    if (!modelNode(id)) moved_.remove(id);
}

bool qSlicerInnerGSHost::offers(Role) const {
  return true;
}

Selector* qSlicerInnerGSHost::createSelector(Role role, QWidget* parent) {
  auto* selector = new qSlicerInnerGSSelector(role, scene_, parent);
  connect(this, &qSlicerInnerGSHost::mrmlSceneChanged, selector, &qSlicerInnerGSSelector::setMRMLScene);
  if (role == Role::Region)
    connect(selector, &qSlicerInnerGSSelector::nodeMade, this, &qSlicerInnerGSHost::fitRegion);
  return selector;
}

/// A new region begins as the first input's box.
void qSlicerInnerGSHost::fitRegion(vtkMRMLNode* node) {
  auto* region = vtkMRMLMarkupsROINode::SafeDownCast(node);
  vtkMRMLVolumeNode* input = parameters_ ? parameters_->GetInputVolumeNode(0) : nullptr;
  if (!region || !input || !input->GetImageData()) return;
  double bounds[6];
  input->GetRASBounds(bounds);
  region->SetCenter((bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2, (bounds[4] + bounds[5]) / 2);
  region->SetSize(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
  region->CreateDefaultDisplayNodes();
}

VolumeInfo qSlicerInnerGSHost::volumeInfo(const QString& id) const {
  return scene_ ? infoOf(vtkMRMLVolumeNode::SafeDownCast(scene_->GetNodeByID(id.toUtf8().constData())))
                : VolumeInfo();
}

//------------------------------------------------------------------------------ reconstruction

Estimate qSlicerInnerGSHost::estimate(const Request& request) {
  Estimate estimate;
  if (!active_) return estimate;
  if (!logic_ || !parameters_) {
    estimate.refusal = tr("There is no parameter set: choose or create one above.");
    return estimate;
  }
  store(request);
  estimate.refusal = QString::fromStdString(logic_->CheckParameters(parameters_));
  if (!estimate.refusal.isEmpty()) return estimate;
  estimate.memory = logic_->EstimateMemory(parameters_);
  estimate.available = availableMemory();
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
    return;
  }
  if (!later || estimating_ || isRunning()) return; // then, a time measured says nothing
  estimating_ = true;
  run([this, later, known]() -> std::function<void()> {
    const auto found = later();
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
  phase_.clear();
  deviceNote_.clear();
  judging_ = false;
  Q_EMIT started();
  return true;
}

void qSlicerInnerGSHost::cancel() {
  if (logic_ && job_) logic_->RequestCancel(job_);
}

bool qSlicerInnerGSHost::isRunning() const {
  return job_ && !job_->IsDone();
}

void qSlicerInnerGSHost::onJob(vtkObject*, unsigned long event, void* data) {
  if (!job_ || data != job_.Get()) return; // a script's
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = job_;
  switch (event) {
  case vtkSlicerInnerGSLogic::JobProgressEvent: {
    const QString phase = QString::fromStdString(job->GetPhase());
    if (phase != phase_) Q_EMIT logged(QString::fromStdString(job->GetDescription()));
    phase_ = phase;
    Progress progress = progressOf(job);
    if (phase.startsWith("Judging")) { // sweeps, loss and PSNR stay those of the fit that makes the result
      std::swap(progress, fit_);
      progress.phase = knownPhase(job->GetPhase().substr(job->GetPhase().find(", ") + 2), Phase::Rendering);
      progress.fraction = fit_.fraction;
      progress.elapsed = fit_.elapsed;
      progress.remaining = fit_.remaining;
    }
    fit_ = progress;
    if (phase.startsWith("Judging") && !judging_)
      Q_EMIT logged(tr("Judging the quality by a second fit that sees only some of the slices."));
    judging_ = phase.startsWith("Judging");
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
  } else {
    Q_EMIT cancelled();
  }
}

QString qSlicerInnerGSHost::folder() const {
  return QSettings().value(kFolder, QDir::homePath()).toString();
}

void qSlicerInnerGSHost::setFolder(const QString& folder) {
  QSettings().setValue(kFolder, folder);
}
