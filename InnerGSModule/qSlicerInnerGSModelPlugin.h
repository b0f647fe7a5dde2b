#ifndef qSlicerInnerGSModelPlugin_h
#define qSlicerInnerGSModelPlugin_h

#include "qSlicerSubjectHierarchyAbstractPlugin.h"

/// Models in the Data module's tree.
class qSlicerInnerGSModelPlugin : public qSlicerSubjectHierarchyAbstractPlugin {
  Q_OBJECT
public:
  typedef qSlicerSubjectHierarchyAbstractPlugin Superclass;
  explicit qSlicerInnerGSModelPlugin(QObject* parent = nullptr);
  ~qSlicerInnerGSModelPlugin() override;

  double canAddNodeToSubjectHierarchy(
      vtkMRMLNode* node,
      vtkIdType parentItemID = vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID) const override;
  double canOwnSubjectHierarchyItem(vtkIdType itemID) const override;
  const QString roleForPlugin() const override;
  QIcon icon(vtkIdType itemID) override;
  QIcon visibilityIcon(int visible) override;
  QString tooltip(vtkIdType itemID) const override;

private:
  Q_DISABLE_COPY(qSlicerInnerGSModelPlugin);
};

#endif
