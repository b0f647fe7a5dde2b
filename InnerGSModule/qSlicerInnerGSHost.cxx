#include "qSlicerInnerGSHost.h"

#include "Core/ReconstructionJob.h"
#include "NodeInfo.h"
#include "ParameterRequest.h"
#include "qSlicerInnerGSSelector.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>
#include <vtkSlicerInnerGSJob.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <QDir>
#include <QSettings>

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
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
  });
}

qSlicerInnerGSHost::~qSlicerInnerGSHost() {
  for (auto* list : {&logicWatches_, &sceneWatches_, &modelWatches_})
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

void qSlicerInnerGSHost::store(const Request& request) {
  if (!parameters_ || !scene_ || scene_->IsClosing() || scene_->IsImporting()) return;
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

void qSlicerInnerGSHost::onModel(vtkObject*, unsigned long, void*) {
  if (!changed_.isActive()) changed_.start();
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
  if (!logic_ || !parameters_) {
    estimate.refusal = tr("There is no parameter set: choose or create one above.");
    return estimate;
  }
  store(request);
  estimate.refusal = QString::fromStdString(logic_->CheckParameters(parameters_));
  if (!estimate.refusal.isEmpty()) return estimate;
  estimate.memory = logic_->EstimateMemory(parameters_);
  estimate.available = availableMemory();
  estimate.seconds = logic_->EstimateSeconds(parameters_);
  estimate.reason = QString::fromStdString(logic_->DescribeDevice(parameters_));
  return estimate;
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
  job_ = logic_->StartReconstruction(parameters_);
  if (!job_) {
    Q_EMIT failed(lastError());
    return false;
  }
  phase_.clear();
  deviceNote_.clear();
  judging_ = false;
  Q_EMIT logged(tr("Reconstruction started."));
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
      progress.note =
          tr("Judging the quality by a second fit that sees only some of the slices.").toStdString();
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
  if (event == vtkSlicerInnerGSLogic::JobFinishedEvent) {
    const Report report = reportOf(job);
    Q_EMIT logged(tr("Finished in %1 s. %2").arg(report.seconds, 0, 'f', 1).arg(report.settings));
    watchModels();
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
    Q_EMIT finished(report);
  } else if (event == vtkSlicerInnerGSLogic::JobFailedEvent) {
    const QString sentence = QString::fromStdString(job->GetErrorMessage());
    Q_EMIT logged(sentence);
    Q_EMIT failed(sentence);
  } else {
    Q_EMIT logged(tr("Cancelled."));
    Q_EMIT cancelled();
  }
}

//------------------------------------------------------------------------------ models

ModelInfo qSlicerInnerGSHost::modelInfo(const QString& id) const {
  return infoOf(modelNode(id));
}

vtkInnerGSModel* qSlicerInnerGSHost::model(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  if (!node || node->IsEmpty()) return nullptr;
  vtkNew<vtkMatrix4x4> toWorld;
  if (!node->GetParentTransformNode() ||
      !node->GetParentTransformNode()->GetMatrixTransformToWorld(toWorld) || toWorld->IsIdentity())
    return node->GetModel();
  std::array<double, 16> matrix;
  std::copy_n(toWorld->GetData(), 16, matrix.begin());
  Moved& moved = moved_[id];
  if (!moved.node || moved.from != node->GetModel() || moved.matrix != matrix) {
    moved = {vtkSmartPointer<vtkMRMLInnerGSModelNode>::New(), node->GetModel(), matrix};
    moved.node->SetModel(node->GetModel());
    moved.node->ApplyTransformMatrix(toWorld);
  }
  return moved.node->GetModel();
}

QString qSlicerInnerGSHost::loadModel(const QString& file, QString* error) {
  vtkMRMLNode* node = logic_ ? logic_->LoadModel(QDir::toNativeSeparators(file).toStdString()) : nullptr;
  if (!node && error) *error = lastError();
  if (node) Q_EMIT logged(tr("Loaded %1").arg(file));
  return idOf(node);
}

QString qSlicerInnerGSHost::saveModel(const QString& id, const QString& file) {
  if (!logic_ || !logic_->SaveModel(modelNode(id), QDir::toNativeSeparators(file).toStdString()))
    return lastError();
  Q_EMIT logged(tr("Saved %1").arg(file));
  Q_EMIT modelsChanged();
  return {};
}

QString qSlicerInnerGSHost::addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                                      QString* error) {
  if (!scene_ || !image) {
    if (error) *error = tr("There is no scene to add a volume to.");
    return {};
  }
  auto* node = vtkMRMLScalarVolumeNode::SafeDownCast(scene_->AddNewNodeByClass(
      "vtkMRMLScalarVolumeNode", scene_->GenerateUniqueName(name.toStdString()).c_str()));
  vtkNew<vtkImageData> own; // a volume node's geometry is in its matrix alone
  own->DeepCopy(image);
  own->SetOrigin(0, 0, 0);
  own->SetSpacing(1, 1, 1);
  own->GetDirectionMatrix()->Identity();
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  node->CreateDefaultDisplayNodes();
  return idOf(node);
}

QString qSlicerInnerGSHost::folder() const {
  return QSettings().value(kFolder, QDir::homePath()).toString();
}

void qSlicerInnerGSHost::setFolder(const QString& folder) {
  QSettings().setValue(kFolder, folder);
}
