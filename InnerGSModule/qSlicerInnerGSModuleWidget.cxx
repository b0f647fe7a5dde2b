#include "qSlicerInnerGSModuleWidget.h"

#include "AltKeys.h"
#include "EndingQuestion.h"
#include "NodeInfo.h"
#include "ParameterRequest.h"
#include "SceneChoices.h"
#include "Widgets/FindPanel.h"
#include "Widgets/LogPanel.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/MotionPanel.h"
#include "Widgets/PanelTools.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"
#include "qSlicerInnerGSHost.h"
#include "qSlicerInnerGSModuleWidget_p.h"
#include "qSlicerInnerGSViews.h"

#include <ctkCollapsibleButton.h>
#include <qMRMLNodeComboBox.h>
#include <qSlicerApplication.h>

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
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QMainWindow>
#include <QMenuBar>
#include <QPushButton>
#include <QStyle>
#include <QTimer>
#include <QVBoxLayout>

#include <utility>

using namespace innergs::ui;
namespace mrml = innergs::mrml;

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

/// A line of text, until there is one.
QLabel* hiddenLine(const char* name) {
  auto* line = named(new QLabel, name);
  line->setWordWrap(true);
  line->hide();
  return line;
}

/// Hidden when it is empty.
void showLine(QLabel* line, const QString& text) {
  line->setText(text);
  line->setVisible(!text.isEmpty());
}

} // namespace

//------------------------------------------------------------------------------ panels

QWidget* qSlicerInnerGSModuleWidgetPrivate::makeParameterRow() {
  const auto tr = [](const char* text) { return qSlicerInnerGSModuleWidget::tr(text); };
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(row->style()->pixelMetric(QStyle::PM_LayoutLeftMargin), 0,
                             row->style()->pixelMetric(QStyle::PM_LayoutRightMargin), 0);
  auto* label = new QLabel(tr("&Parameter set:"));
  parameterSets = named(new qMRMLNodeComboBox, "ParameterNodeComboBox",
                        tr("All choices below, saved with the scene. A scene can have several sets."));
  parameterSets->setNodeTypes({"vtkMRMLInnerGSParameterNode"});
  parameterSets->setNoneEnabled(false);
  parameterSets->setAddEnabled(true);
  parameterSets->setRenameEnabled(true);
  parameterSets->setRemoveEnabled(true);
  parameterSets->setBaseName("InnerGS");
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
  auto* layout = layoutWithoutMargins<QGridLayout>(row);
  auto* label = new QLabel(tr("Slice &view:"));
  sliceView = named(new qMRMLNodeComboBox, "SliceViewComboBox",
                    tr("A slice view linked to the plane below: each follows the other."));
  sliceView->setNodeTypes({"vtkMRMLSliceNode"});
  sliceView->setNoneEnabled(true);
  sliceView->setNoneDisplay(tr("Not linked"));
  sliceView->setAddEnabled(false);
  sliceView->setRemoveEnabled(false);
  label->setBuddy(sliceView);
  modelInView = named(new QCheckBox(tr("Sho&w the model there")), "ModelInViewCheckBox",
                      tr("Draw the model itself into the view, at the view's resolution."));
  modelInView->setEnabled(false);
  planeIn3D = named(new QCheckBox(tr("Show the plane in &3D")), "PlaneIn3DCheckBox",
                    tr("Show the plane with its picture in the 3D views while this section is open."));
  layout->addWidget(label, 0, 0);
  layout->addWidget(sliceView, 0, 1, 1, 2);
  layout->addWidget(modelInView, 1, 1);
  layout->addWidget(planeIn3D, 1, 2, Qt::AlignRight);
  layout->setColumnStretch(1, 1);
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
  maskMessage = hiddenLine("MaskSegmentLabel");
  maskMessage->setTextInteractionFlags(Qt::TextBrowserInteraction);
  part->layout()->addWidget(maskMessage);
  rendering = named(new QPushButton(tr("Show the result in &3D")), "VolumeRenderingButton",
                    tr("Render the last result, or that of the chosen parameter set, in the 3D views."));
  rendering->setCheckable(true);
  rendering->setEnabled(false);
  part->layout()->addWidget(rendering);
  message = hiddenLine("MessageLabel");
  part->layout()->addWidget(message);

  part = querySection = section(tr("Look at any plane"), "QuerySection", false, layout);
  part->layout()->addWidget(makeViewRow());
  transformMessage = hiddenLine("TransformMessageLabel");
  part->layout()->addWidget(transformMessage);
  query = new QueryPanel(host);
  part->layout()->addWidget(query);
  const auto addSection = [&](const QString& title, const char* name, QWidget* panel) {
    section(title, name, false, layout)->layout()->addWidget(panel);
  };
  addSection(tr("Find a structure"), "FindSection", find = new FindPanel(host));
  addSection(tr("Dynamic scan"), "MotionSection", motion = new MotionPanel(host));
  addSection(tr("Model"), "ModelSection", model = new ModelPanel(host));
  addSection(tr("Log"), "LogSection", new LogPanel(host));
  layout->addStretch(1);
  // The texts of the rows of scans, the mask and the big button change: Scan, Add, Mask, Reconstruct, Cancel.
  const QMainWindow* window = qSlicerApplication::application()->mainWindow();
  shareAltKeys(q, window ? window->menuBar() : nullptr,
               {reconstruction->findChild<QWidget*>("inputs"),
                reconstruction->findChild<QWidget*>("maskLabel"),
                reconstruction->findChild<QWidget*>("reconstruct")},
               "NARCK");
}

void qSlicerInnerGSModuleWidgetPrivate::askBeforeTheEnd() {
  QMainWindow* window = qSlicerApplication::application()->mainWindow();
  if (!window) return;
  auto* question = new EndingQuestion(host, window, q_ptr);
  question->guard("FileCloseSceneAction", "on_FileCloseSceneAction_triggered()",
                  qSlicerInnerGSModuleWidget::tr(
                      "A reconstruction is running. Stop it and close the scene? Once its "
                      "iterations have begun, its state is kept, so that you can continue it."));
  question->guard("FileLoadSceneAction", "on_FileLoadSceneAction_triggered()",
                  qSlicerInnerGSModuleWidget::tr(
                      "A reconstruction is running. Stop it and open another scene in place of this one?"));
}

void qSlicerInnerGSModuleWidgetPrivate::connectPanels() {
  Q_Q(qSlicerInnerGSModuleWidget);
  const auto nodeChosen = QOverload<vtkMRMLNode*>::of(&qMRMLNodeComboBox::currentNodeChanged);
  QObject::connect(parameterSets, nodeChosen, q, [this](vtkMRMLNode* node) { setParameters(node); });
  QObject::connect(reconstruction, &ReconstructionPanel::requestChanged, q, [this] { toNode(); });
  const auto keepSet = [this] {
    parameterSets->setRemoveEnabled(!host->isRunning());
  }; // else the fit is lost
  QObject::connect(host, &Host::started, q, keepSet);
  QObject::connect(host, &Host::cancelled, q, keepSet);
  QObject::connect(host, &Host::ended, q, keepSet);
  QObject::connect(host, &Host::failed, q, keepSet);
  QObject::connect(host, &Host::finished, q, keepSet);
  QObject::connect(host, &Host::finished, q, [this](const Report& report) { onFinished(report); });
  QObject::connect(maskMessage, &QLabel::linkActivated, q, [this] {
    if (parameters()) parameters()->SetMaskSegmentID("");
  });
  QObject::connect(host, &Host::volumesChanged, q, [this] {
    updateViewButtons();
    chooseNewScan();
  });
  QObject::connect(rendering, &QPushButton::clicked, q, [this](bool shown) {
    showLine(message, showIn3D(shownVolume(), shown));
    updateViewButtons();
  });

  // One model for all panels, one plane for panel and view.
  QObject::connect(model, &ModelPanel::modelIdChanged, query, &QueryPanel::setModelId);
  QObject::connect(query, &QueryPanel::modelIdChanged, find, &FindPanel::setModelId);
  QObject::connect(find, &FindPanel::modelIdChanged, query, &QueryPanel::setModelId);
  QObject::connect(motion, &MotionPanel::modelIdChanged, query, &QueryPanel::setModelId);
  QObject::connect(query, &QueryPanel::modelIdChanged, model, &ModelPanel::setModelId);
  QObject::connect(query, &QueryPanel::modelIdChanged, q, [this] {
    enableModelInView();
    if (modelInView->isChecked()) showModelInView();
    remember();
  });
  QObject::connect(host, &Host::modelsChanged, q, [this] { explainTransform(); });
  QObject::connect(query, &QueryPanel::modelIdChanged, q, [this] { explainTransform(); });
  QObject::connect(query, &QueryPanel::planeChanged, views, &qSlicerInnerGSViews::setPlane);
  QObject::connect(views, &qSlicerInnerGSViews::planeChanged, query, &QueryPanel::setPlane);
  QObject::connect(sliceView, nodeChosen, q, [this](vtkMRMLNode* node) {
    modelInView->setChecked(false);
    enableModelInView();
    views->link(vtkMRMLSliceNode::SafeDownCast(node));
  });
  QObject::connect(modelInView, &QCheckBox::toggled, q, [this] { showModelInView(); });
  QObject::connect(query, &QueryPanel::pictureChanged, q, [this](const PlaneImage& picture) {
    plane.setPicture(picture, host->modelInfo(query->modelId()).bounds);
  });
  QObject::connect(query, &QueryPanel::windowChanged, q,
                   [this](double lower, double upper) { plane.setWindow(lower, upper); });
  QObject::connect(planeIn3D, &QCheckBox::toggled, q, [this] { showPlaneIn3D(); });
  QObject::connect(querySection, &ctkCollapsibleButton::contentsCollapsed, q, [this] { showPlaneIn3D(); });
}

//------------------------------------------------------------------------------ messages and views

vtkMRMLInnerGSParameterNode* qSlicerInnerGSModuleWidgetPrivate::parameters() const {
  return host->parameterNode();
}

void qSlicerInnerGSModuleWidgetPrivate::explainTransform() {
  showLine(transformMessage, host->modelProblem(query->modelId()));
}

void qSlicerInnerGSModuleWidgetPrivate::explainMask() {
  const std::string id = parameters() ? parameters()->GetMaskSegmentID() : std::string();
  vtkMRMLSegmentationNode* mask = nullptr;
  if (!id.empty())
    for (vtkMRMLNode* node : masksOf(parameters()))
      if (!mask) mask = vtkMRMLSegmentationNode::SafeDownCast(node);
  maskMessage->setVisible(mask != nullptr);
  if (!mask) return;
  vtkSegment* segment = mask->GetSegmentation()->GetSegment(id);
  const char* name = segment ? segment->GetName() : nullptr;
  maskMessage->setText(qSlicerInnerGSModuleWidget::tr("Only the segment '%1' of the mask is used. "
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

void qSlicerInnerGSModuleWidgetPrivate::enableModelInView() {
  const bool possible = sliceView->currentNode() && !query->modelId().isEmpty();
  if (!possible) modelInView->setChecked(false);
  modelInView->setEnabled(possible);
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
  remember();
  if (!next && q->isEntered()) QTimer::singleShot(0, q, [this] { ensureParameters(); }); // it was deleted
}

void qSlicerInnerGSModuleWidgetPrivate::ensureParameters() {
  vtkMRMLScene* in = scene();
  if (!in || in->IsClosing() || in->IsImporting() || in->IsBatchProcessing()) return;
  const bool first = opened;
  auto* node = vtkMRMLInnerGSParameterNode::SafeDownCast(parameterSets->currentNode());
  if (vtkMRMLInnerGSParameterNode* found = first ? openedParameters() : nullptr) node = found;
  std::vector<vtkMRMLNode*> sets;
  if (!node) in->GetNodesByClass("vtkMRMLInnerGSParameterNode", sets);
  for (vtkMRMLNode* set : sets)
    if (!node && !set->GetHideFromEditors()) // those of scripts' jobs are
      node = vtkMRMLInnerGSParameterNode::SafeDownCast(set);
  if (!node) {
    node = vtkMRMLInnerGSParameterNode::SafeDownCast(
        in->AddNewNodeByClass("vtkMRMLInnerGSParameterNode", "InnerGS"));
    if (node) node->EvaluateQualityOn(); // as the panel proposes
    made = node;
  }
  if (node && node->GetNumberOfInputVolumeNodes() == 0 && viewedVolume())
    node->SetInputVolumeNode(viewedVolume());
  parameterSets->setCurrentNode(node);
  if (first && made && made != node && made->GetNumberOfInputVolumeNodes() == 0 &&
      !made->GetResultVolumeNode())
    in->RemoveNode(made); // it was never used
  if (first) showOpenedModel();
  opened = false; // not before: the scene's choices would be overwritten
  remember();
}

//------------------------------------------------------------------------------ scenes

void qSlicerInnerGSModuleWidgetPrivate::sceneWillClose() {
  if (!reconstruction) return;
  modelInView->setChecked(false);
  reconstruction->forgetResult();
  message->hide();
}

void qSlicerInnerGSModuleWidgetPrivate::sceneWillImport() {
  opened = true;
  vtkMRMLInnerGSParameterNode* now = host ? parameters() : nullptr;
  kept = now && now->GetNumberOfInputVolumeNodes() > 0 ? now : nullptr;
}

vtkMRMLInnerGSParameterNode* qSlicerInnerGSModuleWidgetPrivate::openedParameters() {
  if (kept && kept->GetScene() == scene()) return kept;
  if (vtkMRMLInnerGSParameterNode* chosen = mrml::chosenParameters(scene()))
    if (!chosen->GetHideFromEditors()) return chosen;
  std::vector<vtkMRMLNode*> sets;
  scene()->GetNodesByClass("vtkMRMLInnerGSParameterNode", sets);
  for (vtkMRMLNode* set : sets)
    if (set != made && !set->GetHideFromEditors()) return vtkMRMLInnerGSParameterNode::SafeDownCast(set);
  return nullptr;
}

void qSlicerInnerGSModuleWidgetPrivate::showOpenedModel() {
  vtkMRMLInnerGSModelNode* shown = nullptr;
  vtkMRMLSliceNode* slice = modelInView->isChecked() ? nullptr : views->remembered(&shown);
  if (query->modelId().isEmpty() || slice) {
    vtkMRMLInnerGSModelNode* node = shown ? shown : mrml::chosenModel(scene());
    if (!node && parameters()) node = parameters()->GetResultModelNode();
    query->setModelId(idOf(node));
    model->setModelId(idOf(node));
  }
  if (!slice) return;
  sliceView->setCurrentNode(slice);
  views->link(slice); // where it was chosen before the panel was entered
  modelInView->setChecked(true);
}

void qSlicerInnerGSModuleWidgetPrivate::remember() {
  vtkMRMLScene* in = scene();
  if (in && !opened && query && !in->IsClosing() && !in->IsImporting())
    mrml::rememberChoices(in, parameters(), host->modelNode(query->modelId()));
}

vtkMRMLScalarVolumeNode* qSlicerInnerGSModuleWidgetPrivate::newScan() {
  std::vector<vtkMRMLNode*> volumes;
  if (scene()) scene()->GetNodesByClass("vtkMRMLScalarVolumeNode", volumes);
  const QSet<QString> before = std::exchange(scans, {});
  vtkMRMLNode* come = nullptr;
  for (vtkMRMLNode* volume : volumes) {
    if (!isScan(volume)) continue;
    scans.insert(idOf(volume));
    if (!before.contains(idOf(volume)) && (!come || volume == viewedVolume())) come = volume;
  }
  return vtkMRMLScalarVolumeNode::SafeDownCast(come);
}

void qSlicerInnerGSModuleWidgetPrivate::chooseNewScan() {
  vtkMRMLScalarVolumeNode* scan = newScan();
  if (scan && q_ptr->isEntered() && !opened && parameters() &&
      parameters()->GetNumberOfInputVolumeNodes() == 0 && !host->isRunning())
    parameters()->SetInputVolumeNode(scan);
}

vtkMRMLScalarVolumeNode* qSlicerInnerGSModuleWidgetPrivate::viewedVolume() const {
  std::vector<vtkMRMLNode*> views;
  scene()->GetNodesByClass("vtkMRMLSliceCompositeNode", views);
  for (vtkMRMLNode* view : views) {
    const char* id = vtkMRMLSliceCompositeNode::SafeDownCast(view)->GetBackgroundVolumeID();
    auto* volume = vtkMRMLScalarVolumeNode::SafeDownCast(id ? scene()->GetNodeByID(id) : nullptr);
    if (isScan(volume)) return volume;
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
  result = nodeOf<vtkMRMLScalarVolumeNode>(in, report.volumeId);
  views->showInSlices(result);
  qSlicerInnerGSViews::frameIn3D(result);
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
  d->askBeforeTheEnd();
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
  // Before the logic ends what runs, so that the panel can say so.
  qvtkReconnect(scene, vtkMRMLScene::StartCloseEvent, this, SLOT(onSceneWillClose()), 100);
  qvtkReconnect(scene, vtkMRMLScene::StartImportEvent, this, SLOT(onSceneWillImport()));
  if (this->isEntered()) d->ensureParameters();
}

void qSlicerInnerGSModuleWidget::onSceneReady() {
  // Later: opening a scene closes the present one first and brings its own parameter sets.
  QTimer::singleShot(0, this, [this] {
    Q_D(qSlicerInnerGSModuleWidget);
    if (this->isEntered()) d->ensureParameters();
  });
}

void qSlicerInnerGSModuleWidget::onSceneWillClose() {
  Q_D(qSlicerInnerGSModuleWidget);
  d->sceneWillClose();
}

void qSlicerInnerGSModuleWidget::onSceneWillImport() {
  Q_D(qSlicerInnerGSModuleWidget);
  d->sceneWillImport();
}

void qSlicerInnerGSModuleWidget::updateFromParameterNode() {
  Q_D(qSlicerInnerGSModuleWidget);
  d->fromNode();
}

void qSlicerInnerGSModuleWidget::enter() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::enter();
  d->host->setActive(true);
  d->newScan(); // older scans are for people to choose
  d->ensureParameters();
  d->setParameters(d->parameterSets->currentNode());
  d->views->link(vtkMRMLSliceNode::SafeDownCast(d->sliceView->currentNode()));
  d->showPlaneIn3D();
}

void qSlicerInnerGSModuleWidget::exit() {
  Q_D(qSlicerInnerGSModuleWidget);
  this->Superclass::exit();
  d->host->setActive(false); // scripts may use the parameters now
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
