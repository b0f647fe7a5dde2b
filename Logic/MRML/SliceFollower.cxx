#include "SliceFollower.h"

#include "Core/Base/Failure.h"
#include "NodeTransform.h"
#include "Outputs.h"
#include "Queries.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLSliceNode.h>
#include <vtkMRMLTransformableNode.h>

#include <vtkCallbackCommand.h>
#include <vtkImageData.h>
#include <vtkLinearTransform.h>
#include <vtkMatrix4x4.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace innergs::mrml {

namespace {

int nextId() {
  static std::atomic<int> last{0};
  return ++last;
}

} // namespace

SliceFollower::SliceFollower(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice, int maximumPixels,
                             ErrorHandler onError, FineHandler fine)
    : id_(nextId()), model_(model), slice_(slice), maximumPixels_(maximumPixels),
      onError_(std::move(onError)), fine_(std::move(fine)) {
  query_->CentredOff();
  query_->GeometryInImageOff();
  command_->SetClientData(this);
  command_->SetCallback([](vtkObject*, unsigned long event, void* self, void*) {
    // Observers of the output and of errors may delete it.
    const auto follower = static_cast<SliceFollower*>(self)->shared_from_this();
    if (event == vtkMRMLInnerGSModelNode::ModelModifiedEvent) follower->remade_ = true;
    if (event == vtkMRMLTransformableNode::TransformModifiedEvent) follower->placed_ = false;
    follower->update();
  });
  slice->AddObserver(vtkCommand::ModifiedEvent, command_);
  model->AddObserver(vtkMRMLInnerGSModelNode::ModelModifiedEvent, command_);
  model->AddObserver(vtkMRMLTransformableNode::TransformModifiedEvent, command_);
}

SliceFollower::~SliceFollower() {
  if (slice_) slice_->RemoveObserver(command_);
  if (model_) model_->RemoveObserver(command_);
}

vtkMRMLScalarVolumeNode* SliceFollower::output() const {
  return output_;
}

bool SliceFollower::concerns(vtkMRMLNode* node) const {
  return node == model_.Get() || node == slice_.Get() || node == output_.Get();
}

void SliceFollower::setOutput(vtkMRMLScalarVolumeNode* output) {
  output_ = output;
}

void SliceFollower::update() {
  if (updating_ || !output_) return;
  updating_ = true;
  try {
    if (query()) show();
    lastError_.clear();
  } catch (...) {
    const Failure failure = failureOf();
    if (std::exchange(lastError_, failure.sentence) != failure.sentence) onError_(failure);
  }
  updating_ = false;
}

bool SliceFollower::query() {
  found_ = false;
  if (!model_ || !slice_) return false;
  const int* size = slice_->GetDimensions();
  if (size[0] < 1 || size[1] < 1) return false;
  // Fewer pixels than a large view has: each covers `step` of them.
  const double fine = std::max(1.0, double(std::max(size[0], size[1])) / maximumPixels_);
  if (!placed_) toModel_ = transformFromWorld(model_);
  placed_ = true;
  const bool bent = toModel_ && !vtkLinearTransform::SafeDownCast(toModel_);
  PlaneBudget& budget = bent ? bentBudget_ : budget_;
  const double step = std::max(fine, budget.pixelSize(double(size[0]) * size[1]));
  query_->SetModel(modelOf(model_));
  query_->SetTransformToModel(toModel_);
  query_->SetPlaneToRASMatrix(slice_->GetXYToRAS());
  query_->SetDimensions(std::max(1, int(size[0] / step)), std::max(1, int(size[1] / step)));
  query_->SetSpacing(step, step);
  run(query_);
  budget.took(query_->GetQueryMilliseconds(),
              double(query_->GetDimensions()[0]) * query_->GetDimensions()[1]);
  toWorld_->DeepCopy(query_->GetOutputIJKToRASMatrix());
  image_ = vtkSmartPointer<vtkImageData>::New();
  image_->DeepCopy(query_->GetOutput()); // the query overwrites its own image
  found_ = true;
  ++revision_;
  wanted_.reset();
  if (step > fine) {
    wanted_.emplace();
    wanted_->model = modelOf(model_)->GetCoreModel();
    wanted_->toModel = toModel_;
    wanted_->columns = std::max(1, int(size[0] / fine));
    wanted_->rows = std::max(1, int(size[1] / fine));
    wanted_->spacing = fine;
    wanted_->planeToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
    wanted_->planeToRAS->DeepCopy(slice_->GetXYToRAS());
  }
  return true;
}

void SliceFollower::show() {
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> output = output_.Get();
  if (!output || !found_) return;
  if (remade_) setProvenance(output, model_);
  remade_ = false;
  if (wanted_ && fine_) fine_(shared_from_this(), revision_, *std::exchange(wanted_, std::nullopt));
  setVolume(output, image_, toWorld_);
}

void SliceFollower::show(const FinePlanes::Plane& plane) {
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> output = output_.Get();
  if (!output || plane.revision != revision_ || updating_) return;
  const auto alive = shared_from_this();
  updating_ = true;
  setVolume(output, plane.queried.image, plane.queried.ijkToRAS);
  updating_ = false;
}

} // namespace innergs::mrml
