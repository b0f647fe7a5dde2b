#include "AltKeys.h"
#include "EndingQuestion.h"
#include "Widgets/LogPanel.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"
#include "qSlicerInnerGSHost.h"
#include "qSlicerInnerGSModuleWidget_p.h"
#include "qSlicerInnerGSViews.h"

#include <ctkCollapsibleButton.h>
#include <qMRMLNodeComboBox.h>
#include <qSlicerApplication.h>

#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLSliceNode.h>

#include <vtkMatrix4x4.h>

#include <QCheckBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QMainWindow>
#include <QMenuBar>
#include <QPushButton>
#include <QStyle>
#include <QVBoxLayout>

/// The module's panels and how they are joined.

using namespace innergs::ui;

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
  auto* layout = new QGridLayout(row);
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
  planeIn3D = new QCheckBox(tr("Show the plane in &3D"));
  planeIn3D->setObjectName("PlaneIn3DCheckBox");
  planeIn3D->setToolTip(tr("The plane with its picture in the 3D views, while this section is open."));
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
  maskMessage = new QLabel;
  maskMessage->setObjectName("MaskSegmentLabel");
  maskMessage->setWordWrap(true);
  maskMessage->setTextInteractionFlags(Qt::TextBrowserInteraction);
  maskMessage->hide();
  part->layout()->addWidget(maskMessage);
  rendering = new QPushButton(tr("Show the result in &3D"));
  rendering->setObjectName("VolumeRenderingButton");
  rendering->setCheckable(true);
  rendering->setEnabled(false);
  rendering->setToolTip(
      tr("Volume rendering, in the 3D views, of the last result or that of the set chosen since"));
  part->layout()->addWidget(rendering);
  message = new QLabel;
  message->setObjectName("MessageLabel");
  message->setWordWrap(true);
  message->hide();
  part->layout()->addWidget(message);

  part = querySection = section(tr("Look at any plane"), "QuerySection", false, layout);
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
  // Rows of scans and the big button name themselves anew: Scan, Add, Reconstruct, Cancel.
  const QMainWindow* window = qSlicerApplication::application()->mainWindow();
  shareAltKeys(
      q, window ? window->menuBar() : nullptr,
      {reconstruction->findChild<QWidget*>("inputs"), reconstruction->findChild<QWidget*>("reconstruct")},
      "NARC");
}

void qSlicerInnerGSModuleWidgetPrivate::askBeforeTheEnd() {
  QMainWindow* window = qSlicerApplication::application()->mainWindow();
  if (!window) return;
  auto* question = new EndingQuestion(host, window, q_ptr);
  question->guard(
      "FileCloseSceneAction", "on_FileCloseSceneAction_triggered()",
      qSlicerInnerGSModuleWidget::tr("A reconstruction is running. Stop it and close the scene?"));
  question->guard("FileLoadSceneAction", "on_FileLoadSceneAction_triggered()",
                  qSlicerInnerGSModuleWidget::tr(
                      "A reconstruction is running. Stop it and open another scene in place of this one?"));
}

void qSlicerInnerGSModuleWidgetPrivate::connectPanels() {
  Q_Q(qSlicerInnerGSModuleWidget);
  QObject::connect(
      parameterSets,
      static_cast<void (qMRMLNodeComboBox::*)(vtkMRMLNode*)>(&qMRMLNodeComboBox::currentNodeChanged), q,
      [this](vtkMRMLNode* node) { setParameters(node); });
  QObject::connect(reconstruction, &ReconstructionPanel::requestChanged, q, [this] { toNode(); });
  for (const auto ended : {&Host::started, &Host::cancelled}) // the fit would be lost with its set
    QObject::connect(host, ended, q, [this] { parameterSets->setRemoveEnabled(!host->isRunning()); });
  QObject::connect(host, &Host::failed, q, [this] { parameterSets->setRemoveEnabled(!host->isRunning()); });
  QObject::connect(host, &Host::finished, q, [this] { parameterSets->setRemoveEnabled(!host->isRunning()); });
  QObject::connect(host, &Host::finished, q, [this](const Report& report) { onFinished(report); });
  QObject::connect(maskMessage, &QLabel::linkActivated, q, [this] {
    if (parameters()) parameters()->SetMaskSegmentID("");
  });
  QObject::connect(host, &Host::volumesChanged, q, [this] {
    updateViewButtons();
    chooseNewScan();
  });
  QObject::connect(rendering, &QPushButton::clicked, q, [this](bool shown) {
    const QString problem = showIn3D(shownVolume(), shown);
    message->setText(problem);
    message->setVisible(!problem.isEmpty());
    updateViewButtons();
  });

  // One model for all panels, one plane for panel and view.
  QObject::connect(model, &ModelPanel::modelIdChanged, query, &QueryPanel::setModelId);
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
  QObject::connect(
      sliceView,
      static_cast<void (qMRMLNodeComboBox::*)(vtkMRMLNode*)>(&qMRMLNodeComboBox::currentNodeChanged), q,
      [this](vtkMRMLNode* node) {
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
