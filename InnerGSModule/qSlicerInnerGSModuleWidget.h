#ifndef qSlicerInnerGSModuleWidget_h
#define qSlicerInnerGSModuleWidget_h

#include "qSlicerAbstractModuleWidget.h"
#include "qSlicerInnerGSModuleExport.h"

#include <ctkVTKObject.h>

class qSlicerInnerGSModuleWidgetPrivate;

/// The panels, on the scene's parameter sets and with its slice and 3D views.
class Q_SLICER_QTMODULES_INNERGS_EXPORT qSlicerInnerGSModuleWidget : public qSlicerAbstractModuleWidget {
  Q_OBJECT
public:
  typedef qSlicerAbstractModuleWidget Superclass;
  explicit qSlicerInnerGSModuleWidget(QWidget* parent = nullptr);
  ~qSlicerInnerGSModuleWidget() override;

  void enter() override;
  void exit() override;
  bool setEditedNode(vtkMRMLNode* node, QString role = QString(), QString context = QString()) override;
  double nodeEditable(vtkMRMLNode* node) override;

public Q_SLOTS:
  void setMRMLScene(vtkMRMLScene* scene) override;

protected Q_SLOTS:
  void onSceneReady();
  void onSceneWillClose();
  void onSceneWillImport();
  void updateFromParameterNode();

protected:
  void setup() override;
  QScopedPointer<qSlicerInnerGSModuleWidgetPrivate> d_ptr;

private:
  Q_DECLARE_PRIVATE(qSlicerInnerGSModuleWidget);
  Q_DISABLE_COPY(qSlicerInnerGSModuleWidget);
};

#endif
