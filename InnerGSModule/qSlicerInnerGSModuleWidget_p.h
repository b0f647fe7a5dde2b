#pragma once
#include "PlaneIn3D.h"
#include "Widgets/Request.h"
#include "qSlicerInnerGSModuleWidget.h"

class QCheckBox;
class QLabel;
class QPushButton;
class QWidget;
class ctkCollapsibleButton;
class qMRMLNodeComboBox;
class qSlicerInnerGSHost;
class qSlicerInnerGSViews;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;

namespace innergs::ui {
class ModelPanel;
class QueryPanel;
class ReconstructionPanel;
} // namespace innergs::ui

class qSlicerInnerGSModuleWidgetPrivate {
  Q_DECLARE_PUBLIC(qSlicerInnerGSModuleWidget);

public:
  explicit qSlicerInnerGSModuleWidgetPrivate(qSlicerInnerGSModuleWidget& widget) : q_ptr(&widget) {}

  void makePanels();
  QWidget* makeParameterRow();
  QWidget* makeViewRow();
  void connectPanels();

  vtkMRMLInnerGSParameterNode* parameters() const;
  void setParameters(vtkMRMLNode* node);
  /// Takes the first set of the scene, or makes one; an empty one gets the volume that is shown.
  void ensureParameters();
  void fromNode();
  void toNode();
  void onFinished(const innergs::ui::Report& report);
  void showModelInView();
  void showPlaneIn3D();
  void explainTransform(); // where a model's planes cannot be shown
  void updateViewButtons();
  vtkMRMLScalarVolumeNode* shownVolume() const;
  vtkMRMLScalarVolumeNode* viewedVolume() const; // in a slice view's background
  vtkMRMLScene* scene() const { return q_ptr->mrmlScene(); }

  qSlicerInnerGSModuleWidget* const q_ptr;
  qSlicerInnerGSHost* host = nullptr;
  qSlicerInnerGSViews* views = nullptr;
  qMRMLNodeComboBox *parameterSets = nullptr, *sliceView = nullptr;
  innergs::ui::ReconstructionPanel* reconstruction = nullptr;
  innergs::ui::QueryPanel* query = nullptr;
  innergs::ui::ModelPanel* model = nullptr;
  QCheckBox *modelInView = nullptr, *planeIn3D = nullptr;
  ctkCollapsibleButton* querySection = nullptr;
  PlaneIn3D plane;
  QPushButton* rendering = nullptr;
  QLabel *message = nullptr, *transformMessage = nullptr;
  bool updating = false;
};
