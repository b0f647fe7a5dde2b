#include "SliceTransforms.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "NodeGeometry.h"
#include "Outputs.h"

#include <vtkMRMLLinearTransformNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSubjectHierarchyNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkTable.h>
#include <vtkVariant.h>

#include <array>

namespace innergs::mrml {
namespace {

struct SliceRow {
  int scan = 0, slice = 0;
  vtkNew<vtkMatrix4x4> toPlace;
};

std::vector<SliceRow> rowsOf(vtkTable* table) {
  const auto rows = table ? table->GetNumberOfRows() : 0;
  const auto column = [&](const std::string& name) {
    vtkAbstractArray* found = rows > 0 ? table->GetColumnByName(name.c_str()) : nullptr;
    if (!found)
      throw Error(
          ErrorCode::InvalidArgument,
          "This table has no places of slices: choose one made by a reconstruction of several scans.");
    return found;
  };
  vtkAbstractArray *scans = column("Scan"), *slices = column("Slice");
  std::array<vtkAbstractArray*, 12> entries;
  for (int n = 0; n < 12; ++n)
    entries[static_cast<std::size_t>(n)] = column(formatted("M%d%d", n / 4, n % 4));
  std::vector<SliceRow> all(static_cast<std::size_t>(rows));
  for (vtkIdType row = 0; row < rows; ++row) {
    SliceRow& one = all[static_cast<std::size_t>(row)];
    one.scan = scans->GetVariantValue(row).ToInt();
    one.slice = slices->GetVariantValue(row).ToInt();
    for (int n = 0; n < 12; ++n)
      one.toPlace->SetElement(n / 4, n % 4,
                              entries[static_cast<std::size_t>(n)]->GetVariantValue(row).ToDouble());
  }
  return all;
}

} // namespace

std::vector<vtkSmartPointer<vtkMRMLLinearTransformNode>> makeSliceTransforms(vtkMRMLTableNode* slices) {
  const vtkSmartPointer<vtkMRMLTableNode> table = slices;
  const vtkSmartPointer<vtkMRMLScene> scene = table ? table->GetScene() : nullptr;
  if (!scene) throw Error(ErrorCode::InvalidArgument, "There is no table of slices in the scene.");
  const std::vector<SliceRow> rows = rowsOf(table->GetTable());
  const auto hierarchy = [&]() -> vtkMRMLSubjectHierarchyNode* { // observers may remove it
    vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene);
    return vtkMRMLSubjectHierarchyNode::SafeDownCast(
        scene->GetFirstNodeByClass("vtkMRMLSubjectHierarchyNode"));
  };
  vtkIdType folder = vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID;
  if (vtkMRMLSubjectHierarchyNode* tree = hierarchy()) {
    const vtkIdType item = tree->GetItemByDataNode(table);
    folder =
        tree->CreateFolderItem(item == folder ? tree->GetSceneItemID() : tree->GetItemParent(item),
                               nameOf(table, "Slices") + " transforms");
  }
  std::vector<vtkSmartPointer<vtkMRMLLinearTransformNode>> made;
  for (const SliceRow& row : rows) {
    if (table->GetScene() != scene) break;
    const auto node = vtkSmartPointer<vtkMRMLLinearTransformNode>(vtkMRMLLinearTransformNode::SafeDownCast(
        addNode(scene, "vtkMRMLLinearTransformNode", formatted("Scan %d slice %03d", row.scan, row.slice))));
    node->SetMatrixTransformToParent(row.toPlace);
    node->SetNodeReferenceID("InnerGSSlices", table->GetID());
    if (vtkMRMLSubjectHierarchyNode* tree = hierarchy(); tree && node->GetScene() == scene) {
      const vtkIdType item = tree->GetItemByDataNode(node);
      if (item == vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID)
        tree->CreateItem(folder, node);
      else
        tree->SetItemParent(item, folder);
    }
    made.push_back(node);
  }
  return made;
}

} // namespace innergs::mrml
