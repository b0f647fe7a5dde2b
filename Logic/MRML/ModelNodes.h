#pragma once
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <string>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSModelStorageNode;
class vtkMRMLModelNode;
class vtkMRMLScene;

/// Reads and writes model nodes, and turns their Gaussians into nodes for 3D views. All functions throw
/// Error, and change nothing then.
namespace innergs::mrml {

/// A new node with its storage node from an .innergs or .ply file. Made on the main thread, read on any, and
/// added on the main thread again.
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

/// A model file (.innergs) becomes the node's own, in its storage node; a PLY file is an export. Made on the
/// main thread, written on any, and noted on the main thread again.
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

/// At most `maximum` Gaussians (0: all) as points with tensors, in `output` or a new node beside the model.
vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output);

} // namespace innergs::mrml
