#pragma once
#include "Core/Base/Failure.h"
#include "Core/Render/PlaneBudget.h"
#include "FinePlanes.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <functional>
#include <memory>
#include <optional>
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

/// Keeps a volume node on a slice view's plane of a model. Shared, so that an observer of its changes may end
/// it.
class SliceFollower : public std::enable_shared_from_this<SliceFollower> {
public:
  using ErrorHandler = std::function<void(const Failure&)>;
  /// fine: called after a coarse plane, with the request for full resolution once the view is at rest.
  using FineHandler = std::function<void(const std::shared_ptr<SliceFollower>&, int revision, PlaneRequest)>;
  SliceFollower(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice, int maximumPixels,
                ErrorHandler onError, FineHandler fine);
  ~SliceFollower();
  SliceFollower(const SliceFollower&) = delete;
  SliceFollower& operator=(const SliceFollower&) = delete;

  /// Queries the plane, with fewer pixels if all would take too long; changes no node. Throws Error.
  /// Returns false if the view is not shown.
  bool query();
  /// Puts the last queried plane into the output.
  void show();
  /// Shows the full-resolution plane, unless the view has moved since.
  void show(const FinePlanes::Plane& plane);
  void setOutput(vtkMRMLScalarVolumeNode* output);
  bool concerns(vtkMRMLNode* node) const;
  int id() const { return id_; } // unique
  vtkMRMLScalarVolumeNode* output() const;

private:
  void update();

  const int id_;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> model_;
  vtkWeakPointer<vtkMRMLSliceNode> slice_;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> output_;
  int maximumPixels_;
  ErrorHandler onError_;
  std::string lastError_; // reported once, not with every drag
  bool updating_ = false;
  bool remade_ = false; // the output's attributes describe a previous model
  bool found_ = false;  // image_ and toWorld_ match the view
  bool placed_ = false; // toModel_ matches the model's transform
  PlaneBudget budget_{40, 65536}, bentBudget_{40, 1, 1e-3}; // while the view moves
  int revision_ = 0;                                        // of the plane
  FineHandler fine_;
  std::optional<PlaneRequest> wanted_; // the full-resolution request, if the shown plane is coarse
  vtkSmartPointer<vtkAbstractTransform> toModel_;
  vtkSmartPointer<vtkImageData> image_;
  vtkNew<vtkMatrix4x4> toWorld_;
  vtkNew<vtkInnerGSPlaneQuery> query_;
  vtkNew<vtkCallbackCommand> command_;
};

} // namespace innergs::mrml
