#pragma once
#include <vtkSmartPointer.h>

#include <string>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSModelStorageNode;
class vtkMRMLScene;

namespace innergs::mrml {

/// A new node with its storage node from an .innergs or .ply file. Made on the main thread, read on any, and
/// added on the main thread again. Functions throw Error, and change nothing then.
class ModelReading {
public:
  explicit ModelReading(const std::string& fileName);
  ~ModelReading();
  ModelReading(const ModelReading&) = delete;
  ModelReading& operator=(const ModelReading&) = delete;

  void read();
  vtkMRMLInnerGSModelNode* addTo(vtkMRMLScene* scene);

private:
  std::string file_;
  vtkSmartPointer<vtkMRMLInnerGSModelStorageNode> storage_;
  vtkSmartPointer<vtkMRMLInnerGSModelNode> node_;
};

} // namespace innergs::mrml
