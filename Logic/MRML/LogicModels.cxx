#include "Core/Base/Error.h"
#include "LogicInternals.h"
#include "ModelNodes.h"
#include "Queries.h"
#include "SliceTransforms.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLLinearTransformNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLSliceNode.h>

#include <vtkCollection.h>
#include <vtkFloatArray.h>
#include <vtkPoints.h>

#include <exception>
#include <limits>

// The logic's queries of models, and its model files.

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

namespace {

/// A plain pointer that is safe to hold: null if an observer removed the node from the scene and nothing else
/// holds it.
template <class Node>
Node* kept(const vtkSmartPointer<Node>& made, Node* given) {
  return made && ((made == given && made->GetReferenceCount() > 1) || made->GetScene()) ? made.Get()
                                                                                        : nullptr;
}

/// For other threads, which must not copy VTK's weak pointers.
template <class Object>
std::shared_ptr<vtkWeakPointer<Object>> weakly(Object* object) {
  return std::make_shared<vtkWeakPointer<Object>>(object);
}

/// For a thread other than the one that reports the exception.
std::exception_ptr thrownBy(const std::function<void()>& task) {
  try {
    task();
    return nullptr;
  } catch (...) {
    return std::current_exception();
  }
}

} // namespace

bool vtkSlicerInnerGSLogic::CreateSliceTransforms(vtkMRMLTableNode* slices, vtkCollection* transforms) {
  return this->Work->guard([&] {
    for (const auto& made : mrml::makeSliceTransforms(slices))
      if (transforms) transforms->AddItem(made);
  });
}

double vtkSlicerInnerGSLogic::GetValueAtRAS(vtkMRMLInnerGSModelNode* model, double r, double a, double s) {
  vtkNew<vtkPoints> point;
  point->SetDataTypeToDouble();
  point->InsertNextPoint(r, a, s);
  vtkNew<vtkFloatArray> value;
  return this->GetValuesAtRAS(model, point, value) ? static_cast<double>(value->GetValue(0))
                                                   : std::numeric_limits<double>::quiet_NaN();
}

bool vtkSlicerInnerGSLogic::GetValuesAtRAS(vtkMRMLInnerGSModelNode* model, vtkPoints* points,
                                           vtkFloatArray* values) {
  const bool done = this->Work->guard([&] { mrml::evaluate(model, points, values); });
  if (!done && values) values->Initialize();
  return done;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryPlane(vtkMRMLInnerGSModelNode* model,
                                                           vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                           double spacing, vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made = mrml::queryPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing, output);
    if (output) this->StopFollowing(output);
  });
  return kept(made, output);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryUncertaintyPlane(vtkMRMLInnerGSModelNode* model,
                                                                      vtkMatrix4x4* planeToRAS, int columns,
                                                                      int rows, double spacing,
                                                                      vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made =
        mrml::queryUncertaintyPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing, output);
    if (output) this->StopFollowing(output);
  });
  return kept(made, output);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Resample(vtkMRMLInnerGSModelNode* model, double spacing,
                                                         vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made = mrml::resample(this->GetMRMLScene(), model, spacing, output);
    if (output) this->StopFollowing(output);
  });
  return kept(made, output);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ResampleLike(vtkMRMLInnerGSModelNode* model,
                                                             vtkMRMLVolumeNode* reference,
                                                             vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made = mrml::resampleLike(this->GetMRMLScene(), model, reference, output);
    if (output) this->StopFollowing(output);
  });
  return kept(made, output);
}

//------------------------------------------------------------------------------

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::FollowSlice(vtkMRMLInnerGSModelNode* model,
                                                            vtkMRMLSliceNode* slice,
                                                            vtkMRMLScalarVolumeNode* output) {
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive =
      this; // an observer may release it, or remove the nodes
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> keptModel = model;
  const vtkSmartPointer<vtkMRMLSliceNode> keptSlice = slice;
  vtkSmartPointer<vtkMRMLScalarVolumeNode> shown;
  const bool done = this->Work->guard([&] {
    mrml::modelOf(model);
    if (!slice) throw Error(ErrorCode::InvalidArgument, "There is no slice view to follow: choose one.");
    const auto follower = std::make_shared<mrml::SliceFollower>(
        model, slice, this->MaximumFollowPixels,
        [this](const innergs::Failure& failure) { this->Work->fail(failure); },
        [this](const std::shared_ptr<mrml::SliceFollower>& coarse, mrml::PlaneRequest request) {
          this->Work->fine.request(coarse, std::move(request));
        });
    follower->query(); // throws before anything is changed
    shown = mrml::volumeFor(this->GetMRMLScene(), output, model, " slice");
    if (!kept(shown, output) || (this->GetMRMLScene() && !model->GetScene())) return;
    this->StopFollowing(shown);
    mrml::setProvenance(shown, model);
    follower->setOutput(shown);
    this->Work->followers.push_back(follower);
    follower->show();
  });
  return done && this->IsFollowing(shown) ? shown.Get() : nullptr;
}

void vtkSlicerInnerGSLogic::StopFollowing(vtkMRMLScalarVolumeNode* output) {
  std::erase_if(this->Work->followers,
                [&](const auto& follower) { return !output || follower->output() == output; });
}

bool vtkSlicerInnerGSLogic::IsFollowing(vtkMRMLScalarVolumeNode* output) {
  for (const auto& follower : this->Work->followers)
    if (output && follower->output() == output) return true;
  return false;
}

vtkMRMLModelNode* vtkSlicerInnerGSLogic::CreateGaussianModel(vtkMRMLInnerGSModelNode* model, int maximum,
                                                             vtkMRMLModelNode* output) {
  vtkSmartPointer<vtkMRMLModelNode> made;
  this->Work->guard([&] { made = mrml::makeGaussianModel(this->GetMRMLScene(), model, maximum, output); });
  return kept(made, output);
}

vtkMRMLInnerGSModelNode* vtkSlicerInnerGSLogic::LoadModel(const std::string& fileName) {
  vtkMRMLInnerGSModelNode* result = nullptr;
  this->Work->guard([&] {
    mrml::ModelReading reading(fileName);
    reading.read();
    result = reading.addTo(this->GetMRMLScene());
  });
  return result;
}

bool vtkSlicerInnerGSLogic::SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  return this->Work->guard([&] {
    mrml::ModelWriting writing(model, fileName);
    writing.write();
    writing.note();
  });
}

std::function<std::function<vtkMRMLInnerGSModelNode*()>()>
vtkSlicerInnerGSLogic::LoadModelLater(const std::string& fileName) {
  const auto reading = std::make_shared<mrml::ModelReading>(fileName);
  const std::shared_ptr<vtkWeakPointer<vtkSlicerInnerGSLogic>> self = weakly(this);
  return [self, reading] {
    const std::exception_ptr problem = thrownBy([&] { reading->read(); });
    return [self, reading, problem]() -> vtkMRMLInnerGSModelNode* {
      vtkMRMLInnerGSModelNode* result = nullptr;
      if (!*self) return nullptr;
      (*self)->Work->guard([&] {
        if (problem) std::rethrow_exception(problem);
        result = reading->addTo((*self)->GetMRMLScene());
      });
      return result;
    };
  };
}

std::function<std::function<bool()>()> vtkSlicerInnerGSLogic::SaveModelLater(vtkMRMLInnerGSModelNode* model,
                                                                             const std::string& fileName) {
  std::shared_ptr<mrml::ModelWriting> writing;
  const std::exception_ptr refused =
      thrownBy([&] { writing = std::make_shared<mrml::ModelWriting>(model, fileName); });
  const std::shared_ptr<vtkWeakPointer<vtkSlicerInnerGSLogic>> self = weakly(this);
  return [self, writing, refused] {
    const std::exception_ptr problem = refused ? refused : thrownBy([&] { writing->write(); });
    return [self, writing, problem] {
      return *self && (*self)->Work->guard([&] {
        if (problem) std::rethrow_exception(problem);
        writing->note();
      });
    };
  };
}
