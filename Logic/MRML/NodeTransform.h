#pragma once
#include <vtkSmartPointer.h>

class vtkAbstractTransform;
class vtkMRMLTransformableNode;

namespace innergs::mrml {

/// World → node coordinates; null where they are the same. A vtkTransform when it is linear, else a
/// vtkGeneralTransform. A copy, made on the main thread, that another thread may use while the nodes are
/// edited. Throws Error(Geometry) under a transform that cannot be inverted.
vtkSmartPointer<vtkAbstractTransform> transformFromWorld(vtkMRMLTransformableNode* node);

} // namespace innergs::mrml
