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

/// A reconstructed model: a continuous volume made of 3D Gaussians, of a moving scan one in space and time,
/// which shows itself at one time, GetTime(). Queries through vtkSlicerInnerGSLogic
/// honour its parent transform, also one that bends space.
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

  /// Null or empty: nothing yet. Setting it invokes ModelModifiedEvent. Of a moving scan the model at
  /// GetTime(); setting one ends the moving.
  vtkInnerGSModel* GetModel();
  void SetModel(vtkInnerGSModel* model);
  bool IsEmpty();
#ifndef __VTK_WRAP__
  /// What the Gaussians have learned, of a moving scan for every time; not for an empty model.
  void SetFeatures(const std::shared_ptr<const innergs::FeatureModel>& features);
#endif

  ///@{
  /// Of a moving scan; null for others. Setting it invokes ModelModifiedEvent, and so does another time.
  vtkInnerGSDynamicModel* GetDynamicModel();
  void SetDynamicModel(vtkInnerGSDynamicModel* model);
  bool IsDynamic();
  /// s; where everything that looks at the node sees the model. Held within the frames' times.
  double GetTime();
  void SetTime(double seconds);
  ///@}

  /// The axis-aligned box in the node's own coordinates (RAS mm), and in the world's. The uninitialised
  /// bounds (1, -1, ...) when empty.
  virtual void GetBounds(double bounds[6]);
  virtual void GetRASBounds(double bounds[6]);

  /// Moves the model itself (not of a moving scan, which keeps its parent transform): turned, shifted, scaled
  /// and mirrored along the axes of its lattices. A shear of them is refused with an ErrorEvent; when a
  /// parent transform is hardened, it stays as a new parent transform, so that nothing moves.
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
