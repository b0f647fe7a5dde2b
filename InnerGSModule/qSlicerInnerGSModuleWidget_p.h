#pragma once
#include "PlaneIn3D.h"
#include "Widgets/Request.h"
#include "qSlicerInnerGSModuleWidget.h"

#include <vtkWeakPointer.h>

#include <QCoreApplication>
#include <QSet>

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
class FindPanel;
class ModelPanel;
class MotionPanel;
class QueryPanel;
class ReconstructionPanel;
} // namespace innergs::ui

class qSlicerInnerGSModuleWidgetPrivate {
  Q_DECLARE_PUBLIC(qSlicerInnerGSModuleWidget);
  Q_DECLARE_TR_FUNCTIONS(qSlicerInnerGSModuleWidget) // the context that lupdate writes

public:
  explicit qSlicerInnerGSModuleWidgetPrivate(qSlicerInnerGSModuleWidget& widget) : q_ptr(&widget) {}

  void makePanels();
  QWidget* makeParameterRow();
  QWidget* makeViewRow();
  void connectPanels();
  void askBeforeTheEnd();

  vtkMRMLInnerGSParameterNode* parameters() const;
  void setParameters(vtkMRMLNode* node);
  /// Takes the set of an opened scene, else the first one, or makes one. An empty one gets the volume that is
  /// shown.
  void ensureParameters();
  void sceneWillClose();
  void sceneWillImport();
  /// The set of an opened scene, or the one in use before.
  vtkMRMLInnerGSParameterNode* openedParameters();
  void showOpenedModel();
  /// Stores the choices in the scene, for when it is saved.
  void remember();
  /// A scan added since the last call, preferably one that is shown; null if none was.
  vtkMRMLScalarVolumeNode* newScan();
  /// Chooses a scan that was added while none was chosen.
  void chooseNewScan();
  void fromNode();
  void toNode();
  void onFinished(const innergs::ui::Report& report);
  void showModelInView();
  void enableModelInView();
  void showPlaneIn3D();
  void explainTransform(); // says why a model's planes cannot be shown
  void explainMask();      // says that only one segment counts, which no panel can choose
  void updateViewButtons();
  /// Volume rendering of one volume at a time; "" or a sentence.
  QString showIn3D(vtkMRMLScalarVolumeNode* volume, bool shown);
  /// The last result, or that of a parameter set chosen since.
  vtkMRMLScalarVolumeNode* shownVolume() const;
  vtkMRMLScalarVolumeNode* viewedVolume() const; // in a slice view's background, no result
  vtkMRMLScene* scene() const { return q_ptr->mrmlScene(); }

  qSlicerInnerGSModuleWidget* const q_ptr;
  qSlicerInnerGSHost* host = nullptr;
  qSlicerInnerGSViews* views = nullptr;
  qMRMLNodeComboBox *parameterSets = nullptr, *sliceView = nullptr;
  innergs::ui::ReconstructionPanel* reconstruction = nullptr;
  innergs::ui::QueryPanel* query = nullptr;
  innergs::ui::FindPanel* find = nullptr;
  innergs::ui::ModelPanel* model = nullptr;
  innergs::ui::MotionPanel* motion = nullptr;
  QCheckBox *modelInView = nullptr, *planeIn3D = nullptr;
  ctkCollapsibleButton* querySection = nullptr;
  PlaneIn3D plane;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> result, rendered; // made last; last seen in 3D
  QPushButton* rendering = nullptr;
  QLabel *message = nullptr, *transformMessage = nullptr, *maskMessage = nullptr;
  bool updating = false;
  bool opened = true; // a scene was imported, and its choices have not been applied
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> made, kept; // by ensureParameters(); in use before the import
  QSet<QString> scans;                                    // IDs of those already known
};
