#include "qSlicerInnerGSModelPlugin.h"

#include "vtkInnerGSModel.h"

#include <qSlicerSubjectHierarchyPluginHandler.h>

#include <vtkMRMLInnerGSModelNode.h>

namespace {

vtkMRMLInnerGSModelNode* modelOf(vtkIdType itemID) {
  vtkMRMLSubjectHierarchyNode* tree =
      qSlicerSubjectHierarchyPluginHandler::instance()->subjectHierarchyNode();
  return tree && itemID != vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID
             ? vtkMRMLInnerGSModelNode::SafeDownCast(tree->GetItemDataNode(itemID))
             : nullptr;
}

} // namespace

qSlicerInnerGSModelPlugin::qSlicerInnerGSModelPlugin(QObject* parent) : Superclass(parent) {
  this->m_Name = "InnerGSModel";
}

qSlicerInnerGSModelPlugin::~qSlicerInnerGSModelPlugin() = default;

double qSlicerInnerGSModelPlugin::canAddNodeToSubjectHierarchy(vtkMRMLNode* node, vtkIdType) const {
  return vtkMRMLInnerGSModelNode::SafeDownCast(node) ? 0.9 : 0;
}

double qSlicerInnerGSModelPlugin::canOwnSubjectHierarchyItem(vtkIdType itemID) const {
  return modelOf(itemID) ? 0.9 : 0;
}

const QString qSlicerInnerGSModelPlugin::roleForPlugin() const {
  return "InnerGS model";
}

QIcon qSlicerInnerGSModelPlugin::icon(vtkIdType itemID) {
  return modelOf(itemID) ? QIcon(":/Icons/InnerGS.png") : QIcon();
}

QIcon qSlicerInnerGSModelPlugin::visibilityIcon(int) {
  return {}; // models are displayed by the volumes and ellipsoids made from them
}

QString qSlicerInnerGSModelPlugin::tooltip(vtkIdType itemID) const {
  vtkMRMLInnerGSModelNode* node = modelOf(itemID);
  return node && !node->IsEmpty() ? QString::fromStdString(node->GetModel()->GetDescription())
                                  : Superclass::tooltip(itemID);
}
