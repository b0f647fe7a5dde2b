#include "qSlicerInnerGSHost.h"

#include "Core/Base/Failure.h"
#include "Core/Job/ReconstructionJob.h"
#include "NodeInfo.h"
#include "ParameterRequest.h"
#include "qSlicerInnerGSSelector.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>
#include <vtkSlicerInnerGSLogic.h>

#include <QDir>
#include <QEventLoop>
#include <QRunnable>
#include <QSettings>

#include <utility>

using namespace innergs;
using namespace innergs::ui;

namespace {

constexpr const char* kFolder = "InnerGS/Folder";

} // namespace

qSlicerInnerGSHost::qSlicerInnerGSHost(QObject* parent) : Host(parent) {
  qRegisterMetaType<Progress>("innergs::Progress");
  qRegisterMetaType<Report>("innergs::ui::Report");
  changed_.setSingleShot(true);
  changed_.setInterval(0);
  connect(&changed_, &QTimer::timeout, this, [this] {
    if (scene_ && (scene_->IsClosing() || scene_->IsImporting() || scene_->IsBatchProcessing())) return;
    removeOrphans();
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
  modelsMoved_.setInterval(30);
  connect(&modelsMoved_, &QTimer::timeout, this, &Host::modelsChanged);
  volumesEdited_.setSingleShot(true);
  volumesEdited_.setInterval(150);
  connect(&volumesEdited_, &QTimer::timeout, this, [this] {
    const QString now = volumesNow();
    if (now == std::exchange(volumesBefore_, now)) return;
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
  if (!logic) return;
  for (const unsigned long event :
       {vtkSlicerInnerGSLogic::JobStartedEvent, vtkSlicerInnerGSLogic::JobProgressEvent,
        vtkSlicerInnerGSLogic::JobPreviewEvent, vtkSlicerInnerGSLogic::JobFinishedEvent,
        vtkSlicerInnerGSLogic::JobFailedEvent, vtkSlicerInnerGSLogic::JobCancelledEvent})
    logicObservers_.add(logic, event, this, &qSlicerInnerGSHost::onJob);
}

void qSlicerInnerGSHost::setMRMLScene(vtkMRMLScene* scene) {
  if (scene == scene_) return;
  sceneObservers_.clear();
  modelObservers_.clear();
  volumeObservers_.clear();
  chosenObservers_.clear();
  watched_ = watchedMask_ = watchedRegion_ = nullptr;
  places_.clear();
  scene_ = scene;
  if (scene)
    for (const unsigned long event : {vtkMRMLScene::NodeAddedEvent, vtkMRMLScene::NodeAboutToBeRemovedEvent,
                                      vtkMRMLScene::NodeRemovedEvent, vtkMRMLScene::EndBatchProcessEvent,
                                      vtkMRMLScene::EndImportEvent, vtkMRMLScene::EndCloseEvent})
      sceneObservers_.add(scene, event, this, &qSlicerInnerGSHost::onScene);
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
  watchVolumes();
  if (!active) return;
  chosenEdited_.start(); // edited by other modules meanwhile
  changed_.start();
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

/// `work` on a thread, and then what it returns here, while this lives. What it throws is logged, and nothing
/// is called then.
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

/// `work` on a thread, while windows are drawn and jobs go on here. What it throws, a sentence; "" else.
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

QString qSlicerInnerGSHost::folder() const {
  return QSettings().value(kFolder, QDir::homePath()).toString();
}

void qSlicerInnerGSHost::setFolder(const QString& folder) {
  QSettings().setValue(kFolder, folder);
}
