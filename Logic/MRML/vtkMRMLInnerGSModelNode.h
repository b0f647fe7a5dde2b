#ifndef vtkMRMLInnerGSModelNode_h
#define vtkMRMLInnerGSModelNode_h

#include "vtkMRMLTransformableNode.h"
#include "vtkSlicerInnerGSModuleMRMLExport.h"

#include <vtkSmartPointer.h> // member

#include <memory> // std::shared_ptr
#include <string>

namespace innergs {
struct FeatureModel;
}
class vtkInnerGSDynamicModel;
class vtkInnerGSModel;
class vtkMatrix4x4;

/// A reconstructed model: a continuous volume made of 3D Gaussians; for a dynamic scan, one in space and time
/// that is seen at one time, GetTime(). Queries through vtkSlicerInnerGSLogic honour its parent transform,
/// even one that bends space.
class VTK_SLICER_INNERGS_MODULE_MRML_EXPORT vtkMRMLInnerGSModelNode : public vtkMRMLTransformableNode {
public:
  static vtkMRMLInnerGSModelNode* New();
  vtkTypeMacro(vtkMRMLInnerGSModelNode, vtkMRMLTransformableNode);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkMRMLNode* CreateNodeInstance() override;
  const char* GetNodeTagName() override { return "InnerGSModel"; }
  void ReadXMLAttributes(const char** attributes) override;
  void WriteXML(ostream& of, int indent) override;
  vtkMRMLCopyContentMacro(vtkMRMLInnerGSModelNode);
  vtkMRMLStorageNode* CreateDefaultStorageNode() override;
  std::string GetDefaultStorageNodeClassName(const char* filename = nullptr) override;

  enum { ModelModifiedEvent = 18750 };

  /// Null or empty: nothing yet. Setting it invokes ModelModifiedEvent. For a dynamic scan, the model at
  /// GetTime(); setting a model makes the node one of a static scan.
  vtkInnerGSModel* GetModel();
  void SetModel(vtkInnerGSModel* model);
  bool IsEmpty();
#ifndef __VTK_WRAP__
  /// Sets what the Gaussians have learned, for a dynamic scan at every time. The model must not be empty.
  void SetFeatures(const std::shared_ptr<const innergs::FeatureModel>& features);
#endif

  ///@{
  /// The model of a dynamic scan; null for others. Setting it, or another time, invokes ModelModifiedEvent.
  vtkInnerGSDynamicModel* GetDynamicModel();
  void SetDynamicModel(vtkInnerGSDynamicModel* model);
  bool IsDynamic();
  /// The time (s) at which everything that looks at the node sees the model. Clamped to the frames' times.
  double GetTime();
  void SetTime(double seconds);
  ///@}

  /// The axis-aligned box in the node's own coordinates (RAS mm), and in the world's. The uninitialised
  /// bounds (1, -1, ...) when empty.
  virtual void GetBounds(double bounds[6]);
  virtual void GetRASBounds(double bounds[6]);

  /// Moves the model itself (except that of a dynamic scan, which keeps its parent transform): rotates,
  /// shifts, scales and mirrors it along the axes of its grids. Refuses to shear them, with an ErrorEvent;
  /// when a parent transform is hardened, a shear stays as a new parent transform, so that nothing moves.
  void ApplyTransformMatrix(vtkMatrix4x4* matrix) override;
  bool CanApplyNonLinearTransforms() const override;
  bool GetModifiedSinceRead() override;

protected:
  vtkMRMLInnerGSModelNode();
  ~vtkMRMLInnerGSModelNode() override;
  vtkMRMLInnerGSModelNode(const vtkMRMLInnerGSModelNode&);
  void operator=(const vtkMRMLInnerGSModelNode&);

  void OnNodeReferenceRemoved(vtkMRMLNodeReference* reference) override;

  void ShowTime();

  vtkSmartPointer<vtkInnerGSModel> Model;
  vtkSmartPointer<vtkInnerGSDynamicModel> DynamicModel;
  double Time = 0;                    // s
  vtkSmartPointer<vtkMatrix4x4> Rest; // left to a new parent transform when the old one is hardened
};

#endif
