#ifndef vtkMRMLInnerGSModelStorageNode_h
#define vtkMRMLInnerGSModelStorageNode_h

#include "vtkMRMLStorageNode.h"
#include "vtkSlicerInnerGSModuleMRMLExport.h"

#include <memory> // std::weak_ptr
#include <string>

class vtkMRMLInnerGSModelNode;
namespace innergs {
struct FeatureModel;
}

/// Model files (.innergs, everything; of dynamic scans too) and PLY files of Gaussians (.ply, without
/// residual grid and fit state).
class VTK_SLICER_INNERGS_MODULE_MRML_EXPORT vtkMRMLInnerGSModelStorageNode : public vtkMRMLStorageNode {
public:
  static vtkMRMLInnerGSModelStorageNode* New();
  vtkTypeMacro(vtkMRMLInnerGSModelStorageNode, vtkMRMLStorageNode);

  vtkMRMLNode* CreateNodeInstance() override;
  const char* GetNodeTagName() override { return "InnerGSModelStorage"; }
  bool CanReadInReferenceNode(vtkMRMLNode* node) override;

  /// A PLY file that leaves out what the model has is written with a warning, and the model whose storage
  /// node this is counts as unsaved then.
  int WriteData(vtkMRMLNode* node) override;

  /// The sentence with which the last reading or writing failed; "" after success.
  vtkGetMacro(ErrorMessage, std::string);
  vtkGetMacro(ErrorCode, int); // 0 or one of vtkInnerGSAlgorithm::ErrorCodes

  /// Whether the model is, as a whole, what was last read from or written to a file. Unlike the node's
  /// GetModifiedSinceRead() it stays true when the file was a scene bundle's, which Slicer unpacks and
  /// removes.
  bool Holds(vtkMRMLInnerGSModelNode* node);
  /// Notes that the node's content was written to the file by other means.
  void NoteStored(vtkMRMLInnerGSModelNode* node);

protected:
  vtkMRMLInnerGSModelStorageNode();
  ~vtkMRMLInnerGSModelStorageNode() override;
  vtkMRMLInnerGSModelStorageNode(const vtkMRMLInnerGSModelStorageNode&);
  void operator=(const vtkMRMLInnerGSModelStorageNode&);

  void InitializeSupportedReadFileTypes() override;
  void InitializeSupportedWriteFileTypes() override;
  int ReadDataInternal(vtkMRMLNode* node) override;
  int WriteDataInternal(vtkMRMLNode* node) override;
  int Fail();

  std::string ErrorMessage;
  int ErrorCode = 0;
  bool Partly = false; // the last write left something out
#ifndef __VTK_WRAP__
  void Remember(vtkMRMLInnerGSModelNode* node);

  std::weak_ptr<const void> Stored; // the content: a Model or a DynamicField
  std::weak_ptr<const innergs::FeatureModel> StoredFeatures;
#endif
};

#endif
