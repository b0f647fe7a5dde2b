#include "qSlicerInnerGSHost.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/Progress.h"
#include "Core/Job/ReconstructionJob.h"
#include "EllipsoidNodes.h"
#include "NodeInfo.h"
#include "NodeTransform.h"
#include "ParameterRequest.h"
#include "Queries.h"
#include "UncertaintyImage.h"
#include "VolumeObserver.h"
#include "qSlicerInnerGSMotionHost.h"
#include "qSlicerInnerGSSelector.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLMarkupsDisplayNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>
#include <vtkMRMLTransformNode.h>
#include <vtkSlicerInnerGSJob.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkCollection.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSegmentation.h>
#include <vtkTable.h>

#include <QDir>
#include <QEventLoop>
#include <QRunnable>
#include <QSettings>

#include <algorithm>
#include <initializer_list>
#include <utility>

using namespace innergs;
using namespace innergs::ui;

namespace {

constexpr const char* kFolder = "InnerGS/Folder";

} // namespace

qSlicerInnerGSHost::qSlicerInnerGSHost(QObject* parent)
    : Host(parent),
      forecasts_([this](const auto& work) { run(work); }, [this] { Q_EMIT estimateChanged(); }) {
  qRegisterMetaType<Progress>("innergs::Progress");
  qRegisterMetaType<Report>("innergs::ui::Report");
  ellipsoids_ = new EllipsoidNodes([this](const auto& work) { run(work); }, this);
  connect(ellipsoids_, &EllipsoidNodes::changed, this, &Host::modelsChanged);
  connect(ellipsoids_, &EllipsoidNodes::failed, this, &Host::logged);
  motion_ = new qSlicerInnerGSMotionHost(this);
  connect(motion_, &MotionHost::failed, this, &Host::logged);
  connect(motion_, &MotionHost::finished, this, &Host::modelsChanged); // its report names one
  changed_.setSingleShot(true);
  changed_.setInterval(0);
  connect(&changed_, &QTimer::timeout, this, [this] {
    if (scene_ && (scene_->IsClosing() || scene_->IsImporting() || scene_->IsBatchProcessing())) return;
    ellipsoids_->removeOrphans();
    watchModels();
    volumeObserver_->update();
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
    for (const QString& id : std::exchange(remade_, {})) {
      vtkMRMLInnerGSModelNode* node = modelNode(id);
      if (node && ellipsoids_->areShown(node)) showEllipsoids(id, true); // of the new model
    }
  });
  modelsMoved_.setSingleShot(true);
  modelsMoved_.setInterval(30);
  connect(&modelsMoved_, &QTimer::timeout, this, &Host::modelsChanged);
  volumeObserver_ = new VolumeObserver(this);
  connect(volumeObserver_, &VolumeObserver::edited, this, [this] {
    Q_EMIT volumesChanged();
    Q_EMIT estimateChanged();
  });
  chosenEdited_.setSingleShot(true);
  chosenEdited_.setInterval(150);
  connect(&chosenEdited_, &QTimer::timeout, this, &Host::estimateChanged);
  threads_.setMaxThreadCount(1);
}

qSlicerInnerGSHost::~qSlicerInnerGSHost() {
  threads_.clear();
  threads_.waitForDone();
}

void qSlicerInnerGSHost::setLogic(vtkSlicerInnerGSLogic* logic) {
  logicObservers_.clear();
  logic_ = logic;
  motion_->setLogic(logic);
  logicObservers_.add(logic,
                      {vtkSlicerInnerGSLogic::JobStartedEvent, vtkSlicerInnerGSLogic::JobProgressEvent,
                       vtkSlicerInnerGSLogic::JobPreviewEvent, vtkSlicerInnerGSLogic::JobFinishedEvent,
                       vtkSlicerInnerGSLogic::JobFailedEvent, vtkSlicerInnerGSLogic::JobCancelledEvent},
                      this, &qSlicerInnerGSHost::onJob);
}

void qSlicerInnerGSHost::setMRMLScene(vtkMRMLScene* scene) {
  if (scene == scene_) return;
  sceneObservers_.clear();
  modelObservers_.clear();
  chosenObservers_.clear();
  watched_ = watchedRegion_ = nullptr;
  watchedMasks_.clear();
  places_.clear();
  scene_ = scene;
  volumeObserver_->setMRMLScene(scene);
  ellipsoids_->setMRMLScene(scene);
  sceneObservers_.add(scene,
                      {vtkMRMLScene::NodeAddedEvent, vtkMRMLScene::NodeAboutToBeRemovedEvent,
                       vtkMRMLScene::NodeRemovedEvent, vtkMRMLScene::EndBatchProcessEvent,
                       vtkMRMLScene::EndImportEvent, vtkMRMLScene::EndCloseEvent},
                      this, &qSlicerInnerGSHost::onScene);
  Q_EMIT mrmlSceneChanged(scene);
  changed_.start();
}

void qSlicerInnerGSHost::setParameterNode(vtkMRMLInnerGSParameterNode* node) {
  parameters_ = node;
  watchChosen();
}

vtkMRMLInnerGSParameterNode* qSlicerInnerGSHost::parameterNode() const {
  return parameters_;
}

void qSlicerInnerGSHost::setActive(bool active) {
  active_ = active;
  watchChosen();
  volumeObserver_->setActive(active);
  if (!active) return;
  chosenEdited_.start(); // edited by other modules meanwhile
  changed_.start();
}

void qSlicerInnerGSHost::store(const Request& request) {
  if (!active_ || !parameters_ || !scene_ || scene_->IsClosing() || scene_->IsImporting()) return;
  setRequest(parameters_, request);
}

vtkMRMLInnerGSModelNode* qSlicerInnerGSHost::modelNode(const QString& id) const {
  return nodeOf<vtkMRMLInnerGSModelNode>(scene_, id);
}

QString qSlicerInnerGSHost::lastError() const {
  return logic_ ? QString::fromStdString(logic_->GetLastError())
                : tr("The InnerGS module is not completely loaded: restart Slicer.");
}

/// Runs `work` on a thread, then the function that it returns on this one, if this object still exists. If
/// `work` throws, only logs the message.
void qSlicerInnerGSHost::run(const std::function<std::function<void()>()>& work) {
  struct Runnable : QRunnable {
    std::function<void()> call;
    void run() override { call(); }
  };
  auto* runnable = new Runnable;
  runnable->call = [this, work] {
    std::function<void()> after;
    const QString problem = QString::fromStdString(sentenceOf([&] { after = work(); }));
    if (!problem.isEmpty()) after = [this, problem] { Q_EMIT logged(problem); }; // never out of the thread
    if (after) QMetaObject::invokeMethod(this, std::move(after), Qt::QueuedConnection);
  };
  threads_.start(runnable);
}

/// Runs `work` on a thread and waits, while windows are drawn and jobs go on here. Returns what it throws, as
/// a sentence, or "".
QString qSlicerInnerGSHost::runAndWait(const std::function<void()>& work) {
  QEventLoop loop;
  std::string problem;
  run([&]() -> std::function<void()> {
    problem = sentenceOf(work);
    return [&] { loop.quit(); };
  });
  loop.exec(QEventLoop::ExcludeUserInputEvents);
  return QString::fromStdString(problem);
}

MotionHost* qSlicerInnerGSHost::motion() {
  return motion_;
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

bool qSlicerInnerGSHost::hasSlicePoses() const {
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLSequenceNode", nodes);
  return std::any_of(nodes.begin(), nodes.end(), [](vtkMRMLNode* node) {
    auto* sequence = vtkMRMLSequenceNode::SafeDownCast(node);
    return sequence->GetNumberOfDataNodes() > 0 &&
           vtkMRMLTransformNode::SafeDownCast(sequence->GetNthDataNode(0));
  });
}

QString qSlicerInnerGSHost::folder() const {
  return QSettings().value(kFolder, QDir::homePath()).toString();
}

QString qSlicerInnerGSHost::recoveryFolder() const {
  return logic_ ? QString::fromStdString(logic_->GetRecoveryFolder()) : QString();
}

void qSlicerInnerGSHost::setFolder(const QString& folder) {
  QSettings().setValue(kFolder, folder);
}

//------------------------------------------------------------------------------ reconstructions

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
  std::string key;
  if (const auto measure = logic_->EstimateLater(parameters_, &key))
    forecasts_.fill(estimate, key, measure, isRunning());
  return estimate;
}

bool qSlicerInnerGSHost::start(const Request& request) {
  if (isRunning()) {
    Q_EMIT failed(tr("A reconstruction is running: wait for it or cancel it."));
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
  forecasts_.runBegan();
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

/// What ended a job that nobody cancelled, as a sentence; else "".
QString qSlicerInnerGSHost::whyEnded(vtkSlicerInnerGSJob* job) const {
  if (cancelling_) return {};
  if (!scene_ || scene_->IsClosing()) {
    const QString why = tr("Closing or replacing the scene ended the reconstruction.");
    return why + ' ' +
           (job->GetRecoveryFile().empty() ? tr("Open its scans and start again.")
                                           : tr("Open its scans again to continue it."));
  }
  vtkMRMLInnerGSParameterNode* parameters = job->GetParameterNode();
  return parameters && parameters->GetScene() == scene_
             ? QString()
             : tr("Deleting its parameter set ended the reconstruction.");
}

void qSlicerInnerGSHost::cancel() {
  cancelling_ = true;
  if (logic_ && job_) logic_->RequestCancel(job_);
}

/// Whether it waits for another job, a script's.
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
    Q_EMIT progressed(Progress());
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
  forecasts_.runEnded();
  if (event == vtkSlicerInnerGSLogic::JobFinishedEvent) {
    const Report report = reportOf(job);
    watchModels();
    Q_EMIT volumesChanged();
    Q_EMIT modelsChanged();
    Q_EMIT finished(report);
  } else if (event == vtkSlicerInnerGSLogic::JobFailedEvent) {
    Q_EMIT failed(QString::fromStdString(job->GetErrorMessage()));
  } else if (const QString why = whyEnded(job); !why.isEmpty()) {
    Q_EMIT ended(why);
  } else {
    Q_EMIT cancelled();
  }
}

bool qSlicerInnerGSHost::hasResult() const {
  return parameters_ && (parameters_->GetResultVolumeNode() || parameters_->GetResultModelNode());
}

vtkTable* qSlicerInnerGSHost::sliceTable() const {
  vtkMRMLTableNode* node = parameters_ ? parameters_->GetResultSliceTableNode() : nullptr;
  vtkTable* table = node ? node->GetTable() : nullptr;
  return table && table->GetNumberOfRows() > 0 ? table : nullptr;
}

QString qSlicerInnerGSHost::createSliceTransforms(const QString&, QString* error) {
  vtkMRMLTableNode* slices = parameters_ ? parameters_->GetResultSliceTableNode() : nullptr;
  vtkNew<vtkCollection> made;
  if (!logic_ || !logic_->CreateSliceTransforms(slices, made)) {
    *error = lastError();
    return {};
  }
  return tr("Made %n transforms, in a folder beside the table '%1'.", nullptr, made->GetNumberOfItems())
      .arg(QString::fromUtf8(slices->GetName()));
}

//------------------------------------------------------------------------------ models

QString qSlicerInnerGSHost::onlyModel() const {
  std::vector<vtkMRMLNode*> models;
  if (scene_) scene_->GetNodesByClass("vtkMRMLInnerGSModelNode", models);
  return models.size() == 1 ? QString(models.front()->GetID()) : QString();
}

ModelInfo qSlicerInnerGSHost::modelInfo(const QString& id) const {
  ModelInfo info = infoOf(modelNode(id));
  info.ellipsoidsShown = info.ellipsoidsShown || ellipsoids_->arePending(id);
  return info;
}

vtkInnerGSModel* qSlicerInnerGSHost::model(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node && !node->IsEmpty() && placeOf(node).problem.isEmpty() ? node->GetModel() : nullptr;
}

vtkSmartPointer<vtkAbstractTransform> qSlicerInnerGSHost::toModel(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node ? placeOf(node).toModel : nullptr;
}

std::shared_ptr<const UncertaintyVolume> qSlicerInnerGSHost::uncertaintyOf(const QString& id) const {
  vtkMRMLScalarVolumeNode* node = mrml::uncertaintyOf(modelNode(id));
  if (!node) return nullptr;
  auto found = std::make_shared<UncertaintyVolume>();
  found->image = vtkSmartPointer<vtkImageData>::New(); // a worker reads it
  found->image->ShallowCopy(node->GetImageData());
  found->ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  node->GetIJKToRASMatrix(found->ijkToRAS);
  found->usual = innergs::vtk::usualDeviation(found->image);
  return found;
}

QString qSlicerInnerGSHost::modelProblem(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node && !node->IsEmpty() ? placeOf(node).problem : QString();
}

const qSlicerInnerGSHost::Place& qSlicerInnerGSHost::placeOf(vtkMRMLInnerGSModelNode* node) const {
  vtkMRMLTransformNode* parent = node->GetParentTransformNode();
  const vtkMTimeType changed = parent ? parent->GetTransformToWorldMTime() : 0;
  const auto found = places_.constFind(idOf(node));
  if (found != places_.constEnd() && found->parent == parent && found->changed == changed) return *found;
  Place place{parent, changed, nullptr, {}};
  try {
    place.toModel = mrml::transformFromWorld(node);
  } catch (const Error& error) {
    place.problem = QString::fromStdString(error.what());
  }
  return *places_.insert(idOf(node), place);
}

QString qSlicerInnerGSHost::loadModel(const QString& file, QString* error) {
  vtkMRMLNode* node = nullptr;
  if (logic_) {
    const auto read = logic_->LoadModelLater(QDir::toNativeSeparators(file).toStdString());
    std::function<vtkMRMLInnerGSModelNode*()> make;
    const QString problem = runAndWait([&] { make = read(); });
    if (!problem.isEmpty()) {
      if (error) *error = problem;
      return {};
    }
    node = make();
  }
  if (!node && error) *error = lastError();
  if (node) Q_EMIT logged(tr("Loaded %1").arg(file));
  return idOf(node);
}

QString qSlicerInnerGSHost::saveModel(const QString& id, const QString& file) {
  if (!logic_) return lastError();
  const auto write = logic_->SaveModelLater(modelNode(id), QDir::toNativeSeparators(file).toStdString());
  std::function<bool()> note;
  const QString problem = runAndWait([&] { note = write(); });
  if (!problem.isEmpty()) return problem;
  if (!note()) return lastError();
  Q_EMIT logged(tr("Saved %1").arg(file));
  Q_EMIT modelsChanged();
  return {};
}

QString qSlicerInnerGSHost::showEllipsoids(const QString& id, bool shown) {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  if (!node || node->IsEmpty()) return tr("There is no model: choose one.");
  if (shown)
    ellipsoids_->show(node);
  else
    ellipsoids_->hide(node);
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
  vtkNew<vtkImageData> own; // a volume node has its geometry in its matrix alone
  own->DeepCopy(image);
  own->SetOrigin(0, 0, 0);
  own->SetSpacing(1, 1, 1);
  own->GetDirectionMatrix()->Identity();
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  node->CreateDefaultDisplayNodes();
  return idOf(node);
}

QString qSlicerInnerGSHost::addVolumeOf(const QString& modelId, const std::array<double, 2>& window,
                                        vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                                        QString* error) {
  const QString id = addVolume(image, ijkToRAS, name, error);
  auto* volume = nodeOf<vtkMRMLScalarVolumeNode>(scene_, id);
  if (!volume) return id;
  if (vtkMRMLScalarVolumeDisplayNode* display = volume->GetScalarVolumeDisplayNode()) {
    display->SetAutoWindowLevel(0);
    display->SetWindowLevelMinMax(window[0], window[1]);
  }
  if (vtkMRMLInnerGSModelNode* from = modelNode(modelId)) {
    setMadeFrom(volume, from);
    placeBeside(volume, from);
  }
  return id;
}

//------------------------------------------------------------------------------ changes of nodes

void qSlicerInnerGSHost::onScene(vtkObject*, unsigned long event, void* data) {
  if (event == vtkMRMLScene::NodeAboutToBeRemovedEvent) { // while its references are there
    auto* node = vtkMRMLInnerGSModelNode::SafeDownCast(static_cast<vtkMRMLNode*>(data));
    if (node && !scene_->IsClosing()) ellipsoids_->orphan(node);
    return;
  }
  changed_.start();
}

void qSlicerInnerGSHost::onModel(vtkObject* caller, unsigned long event, void*) {
  if (event == vtkMRMLTransformableNode::TransformModifiedEvent) {
    places_.remove(idOf(vtkMRMLNode::SafeDownCast(caller)));
    ellipsoids_->place(vtkMRMLInnerGSModelNode::SafeDownCast(caller));
    if (!modelsMoved_.isActive()) modelsMoved_.start();
    return;
  }
  if (event == vtkMRMLInnerGSModelNode::ModelModifiedEvent)
    remade_.insert(idOf(vtkMRMLNode::SafeDownCast(caller)));
  if (!changed_.isActive()) changed_.start();
}

void qSlicerInnerGSHost::watchModels() {
  modelObservers_.clear();
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLInnerGSModelNode", nodes);
  for (vtkMRMLNode* node : nodes)
    modelObservers_.add(node,
                        {vtkCommand::ModifiedEvent, vtkMRMLInnerGSModelNode::ModelModifiedEvent,
                         vtkMRMLTransformableNode::TransformModifiedEvent},
                        this, &qSlicerInnerGSHost::onModel);
  for (const QString& id : places_.keys())
    if (!modelNode(id)) places_.remove(id);
}

/// Observes what else a request depends on, while the panels are shown.
void qSlicerInnerGSHost::watchChosen() {
  vtkMRMLInnerGSParameterNode* parameters = active_ ? parameters_.GetPointer() : nullptr;
  const std::vector<vtkMRMLNode*> masks = parameters ? masksOf(parameters) : std::vector<vtkMRMLNode*>{};
  vtkMRMLNode* region = parameters ? parameters->GetROINode() : nullptr;
  if (parameters == watched_ && region == watchedRegion_ &&
      std::equal(masks.begin(), masks.end(), watchedMasks_.begin(), watchedMasks_.end()))
    return;
  watched_ = parameters;
  watchedMasks_.assign(masks.begin(), masks.end());
  watchedRegion_ = region;
  chosenEdited_.stop();
  chosenObservers_.clear();
  chosenObservers_.add(parameters, {vtkCommand::ModifiedEvent}, this, &qSlicerInnerGSHost::onParameters);
  const auto watch = [this](vtkMRMLNode* node, std::initializer_list<unsigned long> events) {
    chosenObservers_.add(node, events, this, &qSlicerInnerGSHost::onChosen);
  };
  watch(region, {vtkCommand::ModifiedEvent, vtkMRMLTransformableNode::TransformModifiedEvent,
                 vtkMRMLMarkupsNode::PointModifiedEvent});
  for (vtkMRMLNode* mask : masks) {
    watch(mask, {vtkCommand::ModifiedEvent, vtkMRMLTransformableNode::TransformModifiedEvent});
    if (vtkMRMLSegmentationNode::SafeDownCast(mask)) // of any representation: painted
      watch(mask,
            {vtkMRMLSegmentationNode::SegmentationChangedEvent, vtkSegmentation::SegmentAdded,
             vtkSegmentation::SegmentRemoved, vtkSegmentation::SegmentModified,
             vtkSegmentation::RepresentationModified, vtkSegmentation::ContainedRepresentationNamesModified});
    else
      watch(mask, {vtkMRMLVolumeNode::ImageDataModifiedEvent});
  }
}

void qSlicerInnerGSHost::onParameters(vtkObject*, unsigned long, void*) {
  watchChosen();
}

void qSlicerInnerGSHost::onChosen(vtkObject*, unsigned long, void*) {
  if (!chosenEdited_.isActive()) chosenEdited_.start();
}

/// A new region starts as the first input's box.
void qSlicerInnerGSHost::fitRegion(vtkMRMLNode* node) {
  auto* region = vtkMRMLMarkupsROINode::SafeDownCast(node);
  vtkMRMLVolumeNode* input = parameters_ ? parameters_->GetInputVolumeNode(0) : nullptr;
  if (!region || !input || !input->GetImageData()) return;
  double bounds[6];
  input->GetRASBounds(bounds);
  region->SetCenter((bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2, (bounds[4] + bounds[5]) / 2);
  region->SetSize(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
  region->CreateDefaultDisplayNodes();
  if (auto* display =
          vtkMRMLMarkupsDisplayNode::SafeDownCast(region->GetDisplayNode())) { // a fill would hide the scan
    display->SetFillVisibility(false);
    display->SetOutlineVisibility(true);
  }
}

VolumeInfo qSlicerInnerGSHost::volumeInfo(const QString& id) const {
  auto* node = nodeOf<vtkMRMLVolumeNode>(scene_, id);
  VolumeInfo info = infoOf(node);
  if (logic_ && info.sliceAxis == 2) {
    info.sliceThickness = logic_->GetDicomSliceThickness(node);
    info.passes = logic_->GetNumberOfInterleavedPasses(node);
  }
  return info;
}

//------------------------------------------------------------------------------
// Segments.

std::function<innergs::NamedLabels(const std::stop_token&)>
qSlicerInnerGSHost::labelsFor(const QString& modelId, const QString& labelsId, const QString&,
                              QString* error) {
  auto* labels = nodeOf<vtkMRMLNode>(scene_, labelsId);
  std::function<innergs::NamedLabels(const std::stop_token&)> later;
  if (logic_) later = logic_->LabelsLater(modelNode(modelId), labels);
  if (!later) *error = lastError();
  return later;
}

QString qSlicerInnerGSHost::setFeatures(const QString& modelId,
                                        const std::shared_ptr<const innergs::FeatureModel>& features) {
  vtkMRMLInnerGSModelNode* node = modelNode(modelId);
  if (!node || node->IsEmpty()) return tr("The model is no longer in the scene.");
  node->SetFeatures(features);
  Q_EMIT modelsChanged();
  return {};
}

void qSlicerInnerGSHost::previewSegments(const QString& modelId, const innergs::MadeSegments& made) {
  if (!logic_ || !scene_ || scene_->IsClosing()) return;
  if (preview_ &&
      (made.segments.empty() || preview_->GetNodeReference("InnerGSModel") != modelNode(modelId))) {
    scene_->RemoveNode(preview_);
    preview_ = nullptr;
  }
  if (made.segments.empty()) return;
  if (preview_) preview_->GetSegmentation()->RemoveAllSegments();
  preview_ = logic_->AddSegments(modelNode(modelId), made, preview_);
  if (!preview_) return;
  preview_->SetName(tr("Found").toUtf8().constData());
  preview_->SetSaveWithScene(false);
  if (vtkMRMLNode* display = preview_->GetDisplayNode()) display->SetSaveWithScene(false);
}

QString qSlicerInnerGSHost::addSegments(const QString& modelId, const innergs::MadeSegments& made,
                                        QString* error) {
  vtkMRMLSegmentationNode* kept = logic_ ? logic_->AddSegments(modelNode(modelId), made) : nullptr;
  if (!kept) {
    *error = lastError();
    return {};
  }
  previewSegments(modelId, {}); // it would lie over what is kept
  return QString::fromUtf8(kept->GetName());
}
