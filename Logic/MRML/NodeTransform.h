#pragma once
#include <vtkSmartPointer.h>

class vtkAbstractTransform;
class vtkMRMLTransformableNode;

namespace innergs::mrml {

/// World → node coordinates; null for the identity. A vtkTransform if it is linear, else a
/// vtkGeneralTransform. It is a copy, made on the main thread, that another thread may use while the nodes
/// are edited. Throws Error(Geometry) under a transform that is not invertible.
vtkSmartPointer<vtkAbstractTransform> transformFromWorld(vtkMRMLTransformableNode* node);

} // namespace innergs::mrml
