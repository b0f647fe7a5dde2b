#include "qSlicerInnerGSModuleWidget.h"

#include "NodeInfo.h"
#include "ParameterRequest.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"
#include "qSlicerInnerGSHost.h"
#include "qSlicerInnerGSModuleWidget_p.h"
#include "qSlicerInnerGSViews.h"

#include <ctkCollapsibleButton.h>
#include <qMRMLNodeComboBox.h>

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSliceCompositeNode.h>
#include <vtkMRMLSliceNode.h>
#include <vtkSlicerApplicationLogic.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkMatrix4x4.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>

#include <QCheckBox>
#include <QLabel>
#include <QPushButton>
#include <QTimer>

using namespace innergs::ui;

vtkMRMLInnerGSParameterNode* qSlicerInnerGSModuleWidgetPrivate::parameters() const {
  return host->parameterNode();
}

void qSlicerInnerGSModuleWidgetPrivate::explainTransform() {
  const QString problem = host->modelProblem(query->modelId());
  transformMessage->setText(problem);
  transformMessage->setVisible(!problem.isEmpty());
}

void qSlicerInnerGSModuleWidgetPrivate::explainMask() {
  const std::string id = parameters() ? parameters()->GetMaskSegmentID() : std::string();
  auto* mask = vtkMRMLSegmentationNode::SafeDownCast(parameters() ? parameters()->GetMaskNode() : nullptr);
  const bool one = mask && !id.empty();
  maskMessage->setVisible(one);
  if (!one) return;
  vtkSegment* segment = mask->GetSegmentation()->GetSegment(id);
  const char* name = segment ? segment->GetName() : nullptr;
  maskMessage->setText(qSlicerInnerGSModuleWidget::tr("Of the mask, only the segment “%1” counts. "
                                                      "<a href=\"all\">Use all its segments</a>")
                           .arg(QString::fromUtf8(name ? name : id.c_str()).toHtmlEscaped()));
}

void qSlicerInnerGSModuleWidgetPrivate::showPlaneIn3D() {
  plane.setShown(planeIn3D->isChecked() && !querySection->collapsed() && q_ptr->isEntered());
}

void qSlicerInnerGSModuleWidgetPrivate::showModelInView() {
  const QString problem =
      views->showModel(modelInView->isChecked() ? host->modelNode(query->modelId()) : nullptr);
  if (!problem.isEmpty()) Q_EMIT host->logged(problem);
}

//------------------------------------------------------------------------------ parameter sets

void qSlicerInnerGSModuleWidgetPrivate::setParameters(vtkMRMLNode* node) {
  Q_Q(qSlicerInnerGSModuleWidget);
  auto* next = vtkMRMLInnerGSParameterNode::SafeDownCast(node);
  if (next != parameters()) result = nullptr;
  q->qvtkReconnect(parameters(), q->isEntered() ? next : nullptr, vtkCommand::ModifiedEvent, q,
                   SLOT(updateFromParameterNode()));
  host->setParameterNode(next);
  fromNode();
  if (!next && q->isEntered()) QTimer::singleShot(0, q, [this] { ensureParameters(); }); // it was deleted
}

void qSlicerInnerGSModuleWidgetPrivate::ensureParameters() {
  vtkMRMLScene* in = scene();
  if (!in || in->IsClosing() || in->IsImporting() || in->IsBatchProcessing()) return;
  auto* node = vtkMRMLInnerGSParameterNode::SafeDownCast(parameterSets->currentNode());
  std::vector<vtkMRMLNode*> sets;
  if (!node) in->GetNodesByClass("vtkMRMLInnerGSParameterNode", sets);
  for (vtkMRMLNode* set : sets)
    if (!node && !set->GetHideFromEditors()) // those of scripts' jobs are
      node = vtkMRMLInnerGSParameterNode::SafeDownCast(set);
  if (!node) {
    node = vtkMRMLInnerGSParameterNode::SafeDownCast(
        in->AddNewNodeByClass("vtkMRMLInnerGSParameterNode", "InnerGS"));
    if (node) node->EvaluateQualityOn(); // as the panel proposes
  }
  if (node && node->GetNumberOfInputVolumeNodes() == 0 && viewedVolume())
    node->SetInputVolumeNode(viewedVolume());
  parameterSets->setCurrentNode(node);
}

vtkMRMLScalarVolumeNode* qSlicerInnerGSModuleWidgetPrivate::viewedVolume() const {
  std::vector<vtkMRMLNode*> views;
  scene()->GetNodesByClass("vtkMRMLSliceCompositeNode", views);
  for (vtkMRMLNode* view : views) {
    const char* id = vtkMRMLSliceCompositeNode::SafeDownCast(view)->GetBackgroundVolumeID();
    auto* volume = vtkMRMLScalarVolumeNode::SafeDownCast(id ? scene()->GetNodeByID(id) : nullptr);
    if (volume && !volume->IsA("vtkMRMLLabelMapVolumeNode") && !volume->IsA("vtkMRMLTensorVolumeNode") &&
        !isMade(volume))
      return volume;
  }
  return nullptr;
}

void qSlicerInnerGSModuleWidgetPrivate::fromNode() {
  if (updating) return;
  updating = true;
  reconstruction->setEnabled(parameters() != nullptr);
  if (parameters()) reconstruction->setRequest(requestOf(parameters()));
  updating = false;
  explainMask();
  updateViewButtons();
}

void qSlicerInnerGSModuleWidgetPrivate::toNode() {
  if (updating) return;
  updating = true;
  host->store(reconstruction->request());
  updating = false;
  explainMask();
}

//------------------------------------------------------------------------------ results

vtkMRMLScalarVolumeNode* qSlicerInnerGSModuleWidgetPrivate::shownVolume() const {
  if (result && result->GetScene()) return result;
  return parameters() ? parameters()->GetResultVolumeNode() : nullptr;
}

QString qSlicerInnerGSModuleWidgetPrivate::showIn3D(vtkMRMLScalarVolumeNode* volume, bool shown) {
  if (rendered && rendered != volume && rendered->GetScene()) views->showIn3D(rendered, false);
  return views->showIn3D(volume, shown);
}

void qSlicerInnerGSModuleWidgetPrivate::onFinished(const Report& report) {
  vtkMRMLScene* in = scene();
  if (!in) return;
  result = vtkMRMLScalarVolumeNode::SafeDownCast(in->GetNodeByID(report.volumeId.toUtf8().constData()));
  views->showInSlices(result);
  if (result && rendered != result && qSlicerInnerGSViews::isShownIn3D(rendered)) showIn3D(result, true);
  if (!report.modelId.isEmpty()) {
    query->setModelId(report.modelId);
    model->setModelId(report.modelId);
  }
  updateViewButtons();
}

void qSlicerInnerGSModuleWidgetPrivate::updateViewButtons() {
  vtkMRMLScalarVolumeNode* volume = shownVolume();
  rendering->setEnabled(volume != nullptr);
  rendering->setChecked(qSlicerInnerGSViews::isShownIn3D(volume));
  if (rendering->isChecked()) rendered = volume;
}

//------------------------------------------------------------------------------ the module's widget

qSlicerInnerGSModuleWidget::qSlicerInnerGSModuleWidget(QWidget* parent)
    : Superclass(parent), d_ptr(new qSlicerInnerGSModuleWidgetPrivate(*this)) {}

qSlicerInnerGSModuleWidget::~qSlicerInnerGSModuleWidget() = default;

void qSlicerInnerGSModuleWidget::setup() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::setup();
  auto* logic = vtkSlicerInnerGSLogic::SafeDownCast(this->logic());
  d->host = new qSlicerInnerGSHost(this);
  d->host->setLogic(logic);
  d->views = new qSlicerInnerGSViews(logic, this->appLogic(), this);
  d->makePanels();
  d->connectPanels();
}

void qSlicerInnerGSModuleWidget::setMRMLScene(vtkMRMLScene* scene) {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::setMRMLScene(scene);
  if (!d->host) return;
  d->host->setMRMLScene(scene);
  d->plane.setScene(scene);
  d->sliceView->setMRMLScene(scene);
  d->parameterSets->setMRMLScene(scene);
  for (const unsigned long event : {vtkMRMLScene::EndCloseEvent, vtkMRMLScene::EndImportEvent,
                                    vtkMRMLScene::EndBatchProcessEvent, vtkMRMLScene::EndRestoreEvent})
    qvtkReconnect(scene, event, this, SLOT(onSceneReady()));
  if (this->isEntered()) d->ensureParameters();
}

void qSlicerInnerGSModuleWidget::onSceneReady() {
  // Later: a scene that is opened is closed first, and brings its own parameter sets.
  QTimer::singleShot(0, this, [this] {
    Q_D(qSlicerInnerGSModuleWidget);
    if (this->isEntered()) d->ensureParameters();
  });
}

void qSlicerInnerGSModuleWidget::updateFromParameterNode() {
  Q_D(qSlicerInnerGSModuleWidget);
  d->fromNode();
}

void qSlicerInnerGSModuleWidget::enter() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::enter();
  d->host->setActive(true);
  d->ensureParameters();
  d->setParameters(d->parameterSets->currentNode());
  d->views->link(vtkMRMLSliceNode::SafeDownCast(d->sliceView->currentNode()));
  d->showPlaneIn3D();
}

void qSlicerInnerGSModuleWidget::exit() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::exit();
  d->host->setActive(false); // a script may have the parameters now
  qvtkDisconnect(d->parameters(), vtkCommand::ModifiedEvent, this, SLOT(updateFromParameterNode()));
  d->modelInView->setChecked(false);
  d->showPlaneIn3D();
  d->views->link(nullptr);
}

bool qSlicerInnerGSModuleWidget::setEditedNode(vtkMRMLNode* node, QString, QString) {
  Q_D(qSlicerInnerGSModuleWidget);
  if (vtkMRMLInnerGSParameterNode::SafeDownCast(node)) {
    d->parameterSets->setCurrentNode(node);
    return true;
  }
  if (!vtkMRMLInnerGSModelNode::SafeDownCast(node)) return false;
  d->model->setModelId(QString::fromUtf8(node->GetID()));
  for (const char* name : {"ModelSection", "QuerySection"})
    this->findChild<ctkCollapsibleButton*>(name)->setCollapsed(false);
  return true;
}

double qSlicerInnerGSModuleWidget::nodeEditable(vtkMRMLNode* node) {
  return vtkMRMLInnerGSParameterNode::SafeDownCast(node) || vtkMRMLInnerGSModelNode::SafeDownCast(node)
             ? 0.9
             : this->Superclass::nodeEditable(node);
}
