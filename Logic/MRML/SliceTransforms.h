#pragma once
#include <vtkSmartPointer.h>

#include <vector>

class vtkMRMLLinearTransformNode;
class vtkMRMLTableNode;

namespace innergs::mrml {

/// One transform node per row of a table of slices (vtkSlicerInnerGSJob::GetSliceTableNode()), in a folder of
/// the subject hierarchy beside it: to its parent, RAS mm, from where the scan's header puts the slice to
/// where it lies. Ends early if an observer removes the table. Throws Error(InvalidArgument) for any other
/// table.
std::vector<vtkSmartPointer<vtkMRMLLinearTransformNode>> makeSliceTransforms(vtkMRMLTableNode* slices);

} // namespace innergs::mrml
