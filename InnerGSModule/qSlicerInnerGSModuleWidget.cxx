#include "qSlicerInnerGSModuleWidget.h"

#include "ParameterRequest.h"
#include "Widgets/LogPanel.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"
#include "qSlicerInnerGSHost.h"
#include "qSlicerInnerGSViews.h"

#include <ctkCollapsibleButton.h>
#include <qMRMLNodeComboBox.h>

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSliceCompositeNode.h>
#include <vtkMRMLSliceNode.h>
#include <vtkSlicerApplicationLogic.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkMatrix4x4.h>

#include <QCheckBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QStyle>
#include <QTimer>
#include <QVBoxLayout>

using namespace innergs::ui;

class qSlicerInnerGSModuleWidgetPrivate {
  Q_DECLARE_PUBLIC(qSlicerInnerGSModuleWidget);

public:
  explicit qSlicerInnerGSModuleWidgetPrivate(qSlicerInnerGSModuleWidget& widget) : q_ptr(&widget) {}

  void makePanels();
  QWidget* makeParameterRow();
  QWidget* makeViewRow();
  void connectPanels();

  vtkMRMLInnerGSParameterNode* parameters() const { return host->parameterNode(); }
  void setParameters(vtkMRMLNode* node);
  /// Takes the first set of the scene, or makes one; an empty one gets the volume that is shown.
  void ensureParameters();
  void fromNode();
  void toNode();
  void onFinished(const Report& report);
  void showModelInView();
  void explainTransform(); // where a model's planes cannot be shown
  void updateViewButtons();
  vtkMRMLScalarVolumeNode* shownVolume() const;
  vtkMRMLScalarVolumeNode* viewedVolume() const; // in a slice view's background
  vtkMRMLScene* scene() const { return q_ptr->mrmlScene(); }

  qSlicerInnerGSModuleWidget* const q_ptr;
  qSlicerInnerGSHost* host = nullptr;
  qSlicerInnerGSViews* views = nullptr;
  qMRMLNodeComboBox *parameterSets = nullptr, *sliceView = nullptr;
  ReconstructionPanel* reconstruction = nullptr;
  QueryPanel* query = nullptr;
  ModelPanel* model = nullptr;
  QCheckBox* modelInView = nullptr;
  QPushButton* rendering = nullptr;
  QLabel *message = nullptr, *transformMessage = nullptr;
  bool updating = false;
};

namespace {

ctkCollapsibleButton* section(const QString& title, const char* name, bool open, QBoxLayout* into) {
  auto* button = new ctkCollapsibleButton(title);
  button->setObjectName(name);
  button->setCollapsedHeight(0);
  button->setCollapsed(!open);
  new QVBoxLayout(button);
  into->addWidget(button);
  return button;
}

} // namespace

//------------------------------------------------------------------------------ what is seen

QWidget* qSlicerInnerGSModuleWidgetPrivate::makeParameterRow() {
  const auto tr = [](const char* text) { return qSlicerInnerGSModuleWidget::tr(text); };
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(row->style()->pixelMetric(QStyle::PM_LayoutLeftMargin), 0,
                             row->style()->pixelMetric(QStyle::PM_LayoutRightMargin), 0);
  auto* label = new QLabel(tr("&Parameter set:"));
  parameterSets = new qMRMLNodeComboBox;
  parameterSets->setObjectName("ParameterNodeComboBox");
  parameterSets->setNodeTypes({"vtkMRMLInnerGSParameterNode"});
  parameterSets->setNoneEnabled(false);
  parameterSets->setAddEnabled(true);
  parameterSets->setRenameEnabled(true);
  parameterSets->setRemoveEnabled(true);
  parameterSets->setBaseName("InnerGS");
  parameterSets->setToolTip(tr("All choices below, saved with the scene. A scene can have several sets."));
  QObject::connect(parameterSets, &qMRMLNodeComboBox::nodeAddedByUser, parameterSets, [](vtkMRMLNode* node) {
    if (auto* set = vtkMRMLInnerGSParameterNode::SafeDownCast(node)) set->EvaluateQualityOn(); // as proposed
  });
  label->setBuddy(parameterSets);
  layout->addWidget(label);
  layout->addWidget(parameterSets, 1);
  return row;
}

QWidget* qSlicerInnerGSModuleWidgetPrivate::makeViewRow() {
  const auto tr = [](const char* text) { return qSlicerInnerGSModuleWidget::tr(text); };
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  auto* label = new QLabel(tr("Slice &view:"));
  sliceView = new qMRMLNodeComboBox;
  sliceView->setObjectName("SliceViewComboBox");
  sliceView->setNodeTypes({"vtkMRMLSliceNode"});
  sliceView->setNoneEnabled(true);
  sliceView->setNoneDisplay(tr("Not linked"));
  sliceView->setAddEnabled(false);
  sliceView->setRemoveEnabled(false);
  sliceView->setToolTip(
      tr("A slice view that shares its plane with the plane below: each follows the other."));
  label->setBuddy(sliceView);
  modelInView = new QCheckBox(tr("Sho&w the model there"));
  modelInView->setObjectName("ModelInViewCheckBox");
  modelInView->setToolTip(tr("The model itself, at the view's own resolution, while the view moves."));
  modelInView->setEnabled(false);
  layout->addWidget(label);
  layout->addWidget(sliceView, 1);
  layout->addWidget(modelInView);
  return row;
}

void qSlicerInnerGSModuleWidgetPrivate::makePanels() {
  Q_Q(qSlicerInnerGSModuleWidget);
  const auto tr = [](const char* text) { return qSlicerInnerGSModuleWidget::tr(text); };
  auto* layout = new QVBoxLayout(q);
  layout->addWidget(makeParameterRow());

  ctkCollapsibleButton* part = section(tr("Reconstruct"), "ReconstructSection", true, layout);
  reconstruction = new ReconstructionPanel(host);
  reconstruction->layout()->setContentsMargins(0, 0, 0, 0);
  part->layout()->addWidget(reconstruction);
  rendering = new QPushButton(tr("Show the result in &3D"));
  rendering->setObjectName("VolumeRenderingButton");
  rendering->setCheckable(true);
  rendering->setEnabled(false);
  rendering->setToolTip(tr("Volume rendering of the last result in the 3D views"));
  part->layout()->addWidget(rendering);
  message = new QLabel;
  message->setObjectName("MessageLabel");
  message->setWordWrap(true);
  message->hide();
  part->layout()->addWidget(message);

  part = section(tr("Look at any plane"), "QuerySection", false, layout);
  part->layout()->addWidget(makeViewRow());
  transformMessage = new QLabel;
  transformMessage->setObjectName("TransformMessageLabel");
  transformMessage->setWordWrap(true);
  transformMessage->hide();
  part->layout()->addWidget(transformMessage);
  query = new QueryPanel(host);
  part->layout()->addWidget(query);
  part = section(tr("Model"), "ModelSection", false, layout);
  model = new ModelPanel(host);
  part->layout()->addWidget(model);
  part = section(tr("Log"), "LogSection", false, layout);
  part->layout()->addWidget(new LogPanel(host));
  layout->addStretch(1);
}

void qSlicerInnerGSModuleWidgetPrivate::connectPanels() {
  Q_Q(qSlicerInnerGSModuleWidget);
  QObject::connect(
      parameterSets,
      static_cast<void (qMRMLNodeComboBox::*)(vtkMRMLNode*)>(&qMRMLNodeComboBox::currentNodeChanged), q,
      [this](vtkMRMLNode* node) { setParameters(node); });
  QObject::connect(reconstruction, &ReconstructionPanel::requestChanged, q, [this] { toNode(); });
  QObject::connect(host, &Host::finished, q, [this](const Report& report) { onFinished(report); });
  QObject::connect(host, &Host::volumesChanged, q, [this] { updateViewButtons(); });
  QObject::connect(rendering, &QPushButton::clicked, q, [this](bool shown) {
    const QString problem = views->showIn3D(shownVolume(), shown);
    message->setText(problem);
    message->setVisible(!problem.isEmpty());
    updateViewButtons();
  });

  // One model for all panels, one plane for panel and view.
  QObject::connect(model, &ModelPanel::modelIdChanged, query, &QueryPanel::setModelId);
  QObject::connect(query, &QueryPanel::modelIdChanged, model, &ModelPanel::setModelId);
  QObject::connect(query, &QueryPanel::modelIdChanged, q, [this] {
    if (modelInView->isChecked()) showModelInView();
  });
  QObject::connect(host, &Host::modelsChanged, q, [this] { explainTransform(); });
  QObject::connect(query, &QueryPanel::modelIdChanged, q, [this] { explainTransform(); });
  QObject::connect(query, &QueryPanel::planeChanged, views, &qSlicerInnerGSViews::setPlane);
  QObject::connect(views, &qSlicerInnerGSViews::planeChanged, query, &QueryPanel::setPlane);
  QObject::connect(
      sliceView,
      static_cast<void (qMRMLNodeComboBox::*)(vtkMRMLNode*)>(&qMRMLNodeComboBox::currentNodeChanged), q,
      [this](vtkMRMLNode* node) {
        modelInView->setChecked(false);
        modelInView->setEnabled(node != nullptr);
        views->link(vtkMRMLSliceNode::SafeDownCast(node));
      });
  QObject::connect(modelInView, &QCheckBox::toggled, q, [this] { showModelInView(); });
}

void qSlicerInnerGSModuleWidgetPrivate::explainTransform() {
  const QString problem = host->modelProblem(query->modelId());
  transformMessage->setText(problem);
  transformMessage->setVisible(!problem.isEmpty());
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
  q->qvtkReconnect(parameters(), next, vtkCommand::ModifiedEvent, q, SLOT(updateFromParameterNode()));
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
    if (volume && !volume->IsA("vtkMRMLLabelMapVolumeNode") && !volume->IsA("vtkMRMLTensorVolumeNode"))
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
  updateViewButtons();
}

void qSlicerInnerGSModuleWidgetPrivate::toNode() {
  if (updating) return;
  updating = true;
  host->store(reconstruction->request());
  updating = false;
}

//------------------------------------------------------------------------------ results

vtkMRMLScalarVolumeNode* qSlicerInnerGSModuleWidgetPrivate::shownVolume() const {
  return parameters() ? parameters()->GetResultVolumeNode() : nullptr;
}

void qSlicerInnerGSModuleWidgetPrivate::onFinished(const Report& report) {
  vtkMRMLScene* in = scene();
  if (!in) return;
  views->showInSlices(
      vtkMRMLScalarVolumeNode::SafeDownCast(in->GetNodeByID(report.volumeId.toUtf8().constData())));
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
}

void qSlicerInnerGSModuleWidget::exit() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::exit();
  d->host->setActive(false); // a script may have the parameters now
  qvtkDisconnect(d->parameters(), vtkCommand::ModifiedEvent, this, SLOT(updateFromParameterNode()));
  d->modelInView->setChecked(false);
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
