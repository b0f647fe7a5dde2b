#include "Core/Base/Error.h"
#include "Core/Motion/DynamicField.h"
#include "DynamicWork.h"
#include "Geometry.h"
#include "IO/FilePath.h"
#include "LogicInternals.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "Queries.h"
#include "SequenceNodes.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkSlicerInnerGSDynamicRequest.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <cmath>

// The logic's moving scans.

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

namespace {

/// Of a node's moving model. Throws Error.
std::shared_ptr<const innergs::DynamicField> movingField(vtkMRMLInnerGSModelNode* model) {
  mrml::modelOf(model);
  if (!model->IsDynamic())
    throw Error(ErrorCode::InvalidArgument,
                "The model " + mrml::quoted(model) + " is not of a moving scan: choose one that is.");
  return model->GetDynamicModel()->GetField();
}

vtkMRMLSequenceNode* kept(const vtkSmartPointer<vtkMRMLSequenceNode>& made) {
  return made && made->GetScene() ? made.Get() : nullptr;
}

/// A new sequence follows the model's parent transform through its proxy node only: it is refused.
void refuseParent(vtkMRMLInnerGSModelNode* model) {
  if (model->GetParentTransformNode())
    throw Error(ErrorCode::Geometry,
                "The model " + mrml::quoted(model) +
                    " is under a transform, under which a sequence cannot be put: remove "
                    "the transform first.");
}

} // namespace

vtkSlicerInnerGSJob*
vtkSlicerInnerGSLogic::StartDynamicReconstruction(vtkSlicerInnerGSDynamicRequest* request) {
  Internals& work = *this->Work;
  const bool started = work.guard([&] {
    if (!this->GetMRMLScene())
      throw Error(ErrorCode::InvalidArgument, "The logic has no scene to put the result into: set one.");
    auto task = std::make_shared<mrml::Task>();
    task->dynamic = std::make_shared<mrml::DynamicWork>(request);
    task->scene = this->GetMRMLScene();
    task->recovered = task->dynamic->about();
    task->recoveryFolder = innergs::pathOf(this->GetRecoveryFolder());
    task->job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    const vtkSmartPointer<vtkSlicerInnerGSJob> job = task->job;
    work.queue.submit(std::move(task));
    work.lastJob = job;
  });
  return started ? work.lastJob.Get() : nullptr;
}

bool vtkSlicerInnerGSLogic::ReconstructDynamic(vtkSlicerInnerGSDynamicRequest* request) {
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = this->StartDynamicReconstruction(request);
  if (!job) return false;
  this->WaitForJob(job);
  return job->GetState() == vtkSlicerInnerGSJob::Finished;
}

std::string vtkSlicerInnerGSLogic::CheckDynamicRequest(vtkSlicerInnerGSDynamicRequest* request) {
  return innergs::sentenceOf([&] {
    if (!request) throw Error(ErrorCode::InvalidArgument, "There is no request: give one.");
    const innergs::TimeSeries series = mrml::seriesOf(request->GetSeries(), request->GetInterval(), false);
    mrml::sliceTimingOf(request, series.geometry);
    mrml::framesWanted(request->GetTimes(), request->GetRate(), series.times);
  });
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::PreviewFrame(vtkSlicerInnerGSJob* job, double seconds,
                                                             vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made = output;
  const bool done = this->Work->guard([&] {
    if (!job || !job->GetPreviewModel())
      throw Error(ErrorCode::InvalidArgument,
                  "There is no preview of a moving scan: wait for a JobPreviewEvent of its job.");
    if (!std::isfinite(seconds))
      throw Error(ErrorCode::InvalidArgument, "The time to show must be finite: give it in seconds.");
    if (!this->GetMRMLScene())
      throw Error(ErrorCode::InvalidArgument, "The logic has no scene to put the result into: set one.");
    const auto field = job->GetPreviewModel()->GetField();
    const auto frame = mrml::renderFrames(*field, {seconds}).front();
    if (!made)
      made = vtkMRMLScalarVolumeNode::SafeDownCast(
          mrml::addNode(this->GetMRMLScene(), "vtkMRMLScalarVolumeNode", "InnerGS preview"));
    vtkNew<vtkMatrix4x4> ijkToRAS;
    innergs::vtk::toMatrix(field->canonical.region(), ijkToRAS);
    if (made) mrml::setVolume(made, frame, ijkToRAS);
  });
  return done && made && made->GetScene() ? made.Get() : nullptr;
}

vtkMRMLSequenceNode* vtkSlicerInnerGSLogic::CreateFrames(vtkMRMLInnerGSModelNode* model,
                                                         vtkDoubleArray* times, vtkMRMLSequenceNode* output) {
  vtkSmartPointer<vtkMRMLSequenceNode> made = output;
  const bool done = this->Work->guard([&] {
    const vtkSmartPointer<vtkMRMLInnerGSModelNode> alive = model;
    const auto field = movingField(model);
    refuseParent(model);
    const std::vector<double> wanted = mrml::framesWanted(times, 0, field->times);
    const auto frames = mrml::renderFrames(*field, wanted);
    if (!made)
      made = mrml::addSequence(this->GetMRMLScene(), std::string(model->GetName()) + " frames", model);
    mrml::setProvenance(made, model);
    mrml::fillFrames(made, *field, wanted, frames);
    if (made->GetScene()) mrml::browse(made, nullptr);
  });
  return done ? kept(made) : nullptr;
}

vtkMRMLSequenceNode* vtkSlicerInnerGSLogic::CreateMotion(vtkMRMLInnerGSModelNode* model,
                                                         vtkDoubleArray* times, double from,
                                                         vtkMRMLSequenceNode* output) {
  vtkSmartPointer<vtkMRMLSequenceNode> made = output;
  const bool done = this->Work->guard([&] {
    const vtkSmartPointer<vtkMRMLInnerGSModelNode> alive = model;
    const auto field = movingField(model);
    refuseParent(model);
    if (field->kind == innergs::DynamicKind::Intensity)
      throw Error(ErrorCode::InvalidArgument,
                  "The Gaussians of " + mrml::quoted(model) +
                      " stay in place and change their intensity, so there is no motion: reconstruct with "
                      "Kind = Motion.");
    const std::vector<double> wanted = mrml::framesWanted(times, 0, field->times);
    if (!made)
      made = mrml::addSequence(this->GetMRMLScene(), std::string(model->GetName()) + " motion", model);
    mrml::setProvenance(made, model);
    mrml::fillMotion(made, *field, wanted, from);
    if (made->GetScene()) mrml::browse(made, nullptr);
  });
  return done ? kept(made) : nullptr;
}
