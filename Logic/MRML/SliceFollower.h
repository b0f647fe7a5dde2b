#pragma once
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <functional>
#include <string>

class vtkCallbackCommand;
class vtkInnerGSPlaneQuery;
class vtkMRMLInnerGSModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLSliceNode;

namespace innergs::mrml {

/// Keeps a volume node on a slice view's plane of a model.
class SliceFollower {
public:
  using ErrorHandler = std::function<void(const std::string&)>;
  SliceFollower(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice, vtkMRMLScalarVolumeNode* output,
                int maximumPixels, ErrorHandler onError);
  ~SliceFollower();
  SliceFollower(const SliceFollower&) = delete;
  SliceFollower& operator=(const SliceFollower&) = delete;

  /// Throws Error.
  void update();
  bool concerns(vtkMRMLNode* node) const;
  vtkMRMLScalarVolumeNode* output() const;

private:
  vtkWeakPointer<vtkMRMLInnerGSModelNode> model_;
  vtkWeakPointer<vtkMRMLSliceNode> slice_;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> output_;
  int maximumPixels_;
  ErrorHandler onError_;
  std::string lastError_; // reported once, not with every drag
  bool updating_ = false;
  vtkNew<vtkInnerGSPlaneQuery> query_;
  vtkNew<vtkCallbackCommand> command_;
};

} // namespace innergs::mrml
