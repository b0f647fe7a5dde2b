#ifndef qSlicerInnerGSModule_h
#define qSlicerInnerGSModule_h

#include "qSlicerInnerGSModuleExport.h"
#include "qSlicerLoadableModule.h"

/// Turns slices into a continuous volume of 3D Gaussians: nodes, logic, panel, files.
class Q_SLICER_QTMODULES_INNERGS_EXPORT qSlicerInnerGSModule : public qSlicerLoadableModule {
  Q_OBJECT
  Q_PLUGIN_METADATA(IID "org.slicer.modules.loadable.qSlicerLoadableModule/1.0");
  Q_INTERFACES(qSlicerLoadableModule);

public:
  typedef qSlicerLoadableModule Superclass;
  explicit qSlicerInnerGSModule(QObject* parent = nullptr);
  ~qSlicerInnerGSModule() override;

  qSlicerGetTitleMacro(tr("InnerGS"));
  QString helpText() const override;
  QString acknowledgementText() const override;
  QStringList contributors() const override;
  QIcon icon() const override;
  QStringList categories() const override;
  QStringList dependencies() const override;
  QStringList associatedNodeTypes() const override;

protected:
  void setup() override;
  qSlicerAbstractModuleRepresentation* createWidgetRepresentation() override;
  vtkMRMLAbstractLogic* createLogic() override;

private:
  Q_DISABLE_COPY(qSlicerInnerGSModule);
};

#endif
