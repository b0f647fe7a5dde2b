#pragma once
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <string>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSModelStorageNode;

namespace innergs::mrml {

/// A model file (.innergs) becomes the node's own, in its storage node; a PLY file is an export. Made on the
/// main thread, written on any, and noted on the main thread again. Functions throw Error, and change nothing
/// then.
class ModelWriting {
public:
  ModelWriting(vtkMRMLInnerGSModelNode* model, const std::string& fileName);
  ~ModelWriting();
  ModelWriting(const ModelWriting&) = delete;
  ModelWriting& operator=(const ModelWriting&) = delete;

  void write();
  /// Records the file in the node's storage node, if the node still holds what was written.
  void note();

private:
  std::string file_;
  bool own_;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> model_;
  vtkSmartPointer<vtkMRMLInnerGSModelStorageNode> storage_;
  vtkSmartPointer<vtkMRMLInnerGSModelNode> copy_;
};

} // namespace innergs::mrml
