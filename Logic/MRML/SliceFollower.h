#pragma once
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <functional>
#include <memory>
#include <string>

class vtkAbstractTransform;
class vtkCallbackCommand;
class vtkImageData;
class vtkMatrix4x4;
class vtkInnerGSPlaneQuery;
class vtkMRMLInnerGSModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLSliceNode;

namespace innergs::mrml {

/// Keeps a volume node on a slice view's plane of a model. Shared, so that an observer of what it changes may
/// end it.
class SliceFollower : public std::enable_shared_from_this<SliceFollower> {
public:
  using ErrorHandler = std::function<void(const std::string&)>;
  SliceFollower(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice, int maximumPixels,
                ErrorHandler onError);
  ~SliceFollower();
  SliceFollower(const SliceFollower&) = delete;
  SliceFollower& operator=(const SliceFollower&) = delete;

  /// Looks up the plane; throws Error and changes no node. False when the view is not shown.
  bool query();
  /// What was looked up last goes into the output.
  void show();
  void setOutput(vtkMRMLScalarVolumeNode* output);
  bool concerns(vtkMRMLNode* node) const;
  vtkMRMLScalarVolumeNode* output() const;

private:
  void update();

  vtkWeakPointer<vtkMRMLInnerGSModelNode> model_;
  vtkWeakPointer<vtkMRMLSliceNode> slice_;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> output_;
  int maximumPixels_;
  ErrorHandler onError_;
  std::string lastError_; // reported once, not with every drag
  bool updating_ = false;
  bool remade_ = false; // the model is another than the output's attributes say
  bool found_ = false;  // image_ and toWorld_ are the view's
  bool placed_ = false; // toModel_ is the model's transform now
  double msPerPixel_ = 1e-3;
  vtkSmartPointer<vtkAbstractTransform> toModel_;
  vtkSmartPointer<vtkImageData> image_;
  vtkNew<vtkMatrix4x4> toWorld_;
  vtkNew<vtkInnerGSPlaneQuery> query_;
  vtkNew<vtkCallbackCommand> command_;
};

} // namespace innergs::mrml
