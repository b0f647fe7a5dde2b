#pragma once
#include "Widgets/Host.h"

class qMRMLNodeComboBox;
class vtkMRMLNode;
class vtkMRMLScene;

/// A choice among the scene's nodes.
class qSlicerInnerGSSelector : public innergs::ui::Selector {
  Q_OBJECT
public:
  qSlicerInnerGSSelector(innergs::ui::Host::Role role, vtkMRMLScene* scene, QWidget* parent);
  QString currentId() const override;
  void setCurrentId(const QString& id) override;
  void setMRMLScene(vtkMRMLScene* scene);

Q_SIGNALS:
  /// By the user, through the selector's menu.
  void nodeMade(vtkMRMLNode* node);

private:
  qMRMLNodeComboBox* combo_;
};
