#include "Queries.h"

#include "Core/Base/Error.h"
#include "Geometry.h"
#include "NodeGeometry.h"
#include "NodeTransform.h"
#include "Outputs.h"
#include "UncertaintyImage.h"
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSPointQuery.h"
#include "vtkInnerGSResample.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>

#include <vtkAbstractTransform.h>
#include <vtkCallbackCommand.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include <cmath>

namespace innergs::mrml {

vtkInnerGSModel* modelOf(vtkMRMLInnerGSModelNode* node) {
  if (!node) throw Error(ErrorCode::InvalidArgument, "There is no model: choose one.");
  if (node->IsEmpty())
    throw Error(ErrorCode::NoData, "The model " + quoted(node) + " is empty: reconstruct or load one first.");
  return node->GetModel();
}

void fromWorld(vtkMRMLInnerGSModelNode* node, vtkMatrix4x4* worldToNode) {
  toWorld(node, worldToNode);
  worldToNode->Invert();
}

void run(vtkInnerGSAlgorithm* filter) {
  vtkNew<vtkCallbackCommand> quiet; // the message is passed on as an exception
  const unsigned long tag = filter->AddObserver(vtkCommand::ErrorEvent, quiet);
  filter->Update();
  filter->RemoveObserver(tag);
  filter->RethrowError();
}

vtkSmartPointer<vtkMRMLScalarVolumeNode> volumeFor(vtkMRMLScene* scene, vtkMRMLScalarVolumeNode* output,
                                                   vtkMRMLInnerGSModelNode* model, const char* suffix) {
  if (output) return output;
  if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a volume to: set one.");
  const std::string name = nameOf(model, "Model") + suffix;
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made =
      vtkMRMLScalarVolumeNode::SafeDownCast(addNode(scene, "vtkMRMLScalarVolumeNode", name));
  placeBeside(made, model);
  return made;
}

void setProvenance(vtkMRMLNode* output, vtkMRMLInnerGSModelNode* model) {
  if (!output || !model) return;
  MRMLNodeModifyBlocker blocker(output);
  const std::string prefix = "InnerGS.";
  for (const std::string& name : output->GetAttributeNames()) // of a previous model
    if (name.compare(0, prefix.size(), prefix) == 0 && !model->GetAttribute(name.c_str()))
      output->RemoveAttribute(name.c_str());
  for (const std::string& name : model->GetAttributeNames())
    if (name.compare(0, prefix.size(), prefix) == 0)
      output->SetAttribute(name.c_str(), model->GetAttribute(name.c_str()));
  if (!output->GetAttribute("InnerGS.Version")) output->SetAttribute("InnerGS.Version", INNERGS_VERSION);
  output->SetNodeReferenceID("InnerGSModel", model->GetID());
}

void evaluate(vtkMRMLInnerGSModelNode* model, vtkPoints* points, vtkFloatArray* values) {
  if (!points || !values)
    throw Error(ErrorCode::InvalidArgument, "There are no points to evaluate, or no array for the values.");
  vtkNew<vtkInnerGSPointQuery> query;
  query->SetModel(modelOf(model));
  vtkNew<vtkPoints> local;
  local->SetDataTypeToDouble();
  const auto toModel = transformFromWorld(model);
  if (toModel) toModel->TransformPoints(points, local);
  vtkNew<vtkCallbackCommand> quiet;
  query->AddObserver(vtkCommand::ErrorEvent, quiet);
  if (!query->Evaluate(toModel ? local.Get() : points, values))
    throw Error(vtkInnerGSAlgorithm::FromErrorNumber(query->GetErrorCode()), query->GetErrorMessage());
}

namespace {

/// Keeps alive what observers of new nodes may remove from the scene.
struct Alive {
  Alive(vtkMRMLInnerGSModelNode* model, vtkMRMLScalarVolumeNode* output,
        vtkMRMLVolumeNode* reference = nullptr)
      : model(model), output(output), reference(reference) {}
  vtkSmartPointer<vtkMRMLInnerGSModelNode> model;
  vtkSmartPointer<vtkMRMLScalarVolumeNode> output;
  vtkSmartPointer<vtkMRMLVolumeNode> reference;
};

/// Sets the same spacing (mm in the world) along every axis of the model's grid, however its parent
/// scales.
void setSpacing(vtkInnerGSResample* filter, vtkInnerGSModel* model, vtkMatrix4x4* modelToWorld,
                double spacing) {
  vtkNew<vtkMatrix4x4> ijkToModel, ijkToWorld;
  int size[3];
  if (spacing == 0 || !model->GetDomain(ijkToModel, size)) return; // the filter reports what is missing
  vtkMatrix4x4::Multiply4x4(modelToWorld, ijkToModel, ijkToWorld);
  double local[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto length = [&](vtkMatrix4x4* m) {
      return std::hypot(m->GetElement(0, axis), m->GetElement(1, axis), m->GetElement(2, axis));
    };
    local[axis] = spacing * length(ijkToModel) / length(ijkToWorld);
  }
  filter->SetOutputSpacing(local);
}

/// Rejects a nonlinear parent transform for a grid. Throws Error(Geometry).
void refuseBend(vtkMRMLInnerGSModelNode* model) {
  vtkMRMLTransformNode* parent = model->GetParentTransformNode();
  if (parent && !parent->IsTransformToWorldLinear())
    throw Error(ErrorCode::Geometry, quoted(model) +
                                         " is under a transform that bends space: query planes or points, "
                                         "or remove the transform.");
}

/// Rejects a parent transform that shears a grid.
void refuseShear(vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* grid) {
  const int one[3] = {1, 1, 1}, first[3] = {0, 0, 0};
  try {
    vtk::gridOf(grid, one, first, quoted(model));
  } catch (const Error&) {
    throw Error(ErrorCode::Geometry, quoted(model) +
                                         " is under a transform that shears voxels: query planes, or "
                                         "correct or remove the transform.");
  }
}

} // namespace

vtkMRMLScalarVolumeNode* uncertaintyOf(vtkMRMLInnerGSModelNode* model) {
  auto* node =
      model ? vtkMRMLScalarVolumeNode::SafeDownCast(model->GetNodeReference(kUncertaintyRole)) : nullptr;
  if (!node || !node->GetImageData()) return nullptr;
  if (auto* measured = vtkMRMLLabelMapVolumeNode::SafeDownCast(node->GetNodeReference(kMeasuredRole)))
    vtk::restoreMeasured(node->GetImageData(), measured->GetImageData());
  return node;
}

namespace {

vtkSmartPointer<vtkMRMLScalarVolumeNode> queryPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                    double spacing, vtkMRMLScalarVolumeNode* output,
                                                    vtkMRMLScalarVolumeNode* deviation) {
  if (!planeToRAS)
    throw Error(ErrorCode::InvalidArgument, "There is no matrix that places the plane: give one.");
  if (columns < 1 || rows < 1 || !(spacing > 0))
    throw Error(ErrorCode::InvalidArgument,
                "A plane needs at least one pixel a side and a spacing above 0 mm.");
  const Alive alive(model, output, deviation);
  vtkNew<vtkInnerGSPlaneQuery> query;
  query->SetModel(modelOf(model));
  query->SetTransformToModel(transformFromWorld(model));
  query->SetPlaneToRASMatrix(planeToRAS);
  query->SetDimensions(columns, rows);
  query->SetSpacing(spacing, spacing);
  query->GeometryInImageOff();
  if (deviation) {
    vtkNew<vtkMatrix4x4> ijkToRAS;
    deviation->GetIJKToRASMatrix(ijkToRAS);
    query->SetStandardDeviationData(deviation->GetImageData());
    query->SetStandardDeviationIJKToRASMatrix(ijkToRAS);
  }
  run(query);
  auto volume = volumeFor(scene, output, model, deviation ? " plane standard deviation" : " plane");
  setProvenance(volume, model);
  if (deviation)
    setDeviation(volume, query->GetOutputStandardDeviation(), query->GetOutputIJKToRASMatrix(), deviation);
  else
    setVolume(volume, query->GetOutput(), query->GetOutputIJKToRASMatrix());
  return volume;
}

} // namespace

vtkSmartPointer<vtkMRMLScalarVolumeNode> queryPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                    double spacing, vtkMRMLScalarVolumeNode* output) {
  return queryPlane(scene, model, planeToRAS, columns, rows, spacing, output, nullptr);
}

vtkSmartPointer<vtkMRMLScalarVolumeNode>
queryUncertaintyPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* planeToRAS,
                      int columns, int rows, double spacing, vtkMRMLScalarVolumeNode* output) {
  modelOf(model);
  auto* deviation = uncertaintyOf(model);
  if (!deviation)
    throw Error(ErrorCode::NoData, "How far " + quoted(model) +
                                       " may be off is not known: reconstruct it with its uncertainty.");
  if (output == deviation)
    throw Error(ErrorCode::InvalidArgument,
                "The output is the uncertainty of the whole model: choose another.");
  return queryPlane(scene, model, planeToRAS, columns, rows, spacing, output, deviation);
}

vtkSmartPointer<vtkMRMLScalarVolumeNode> resample(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                  double spacing, vtkMRMLScalarVolumeNode* output) {
  if (!(spacing >= 0)) throw Error(ErrorCode::InvalidArgument, "The spacing must be above 0 mm, or 0.");
  const Alive alive(model, output);
  vtkNew<vtkInnerGSResample> filter;
  filter->SetModel(modelOf(model));
  filter->GeometryInImageOff();
  vtkNew<vtkMatrix4x4> modelToWorld, ijkToWorld;
  refuseBend(model);
  toWorld(model, modelToWorld);
  vtkNew<vtkMatrix4x4> domain;
  int domainSize[3];
  if (model->GetModel()->GetDomain(domain, domainSize)) {
    vtkMatrix4x4::Multiply4x4(modelToWorld, domain, ijkToWorld);
    refuseShear(model, ijkToWorld);
  }
  setSpacing(filter, model->GetModel(), modelToWorld, spacing);
  run(filter);
  vtkMatrix4x4::Multiply4x4(modelToWorld, filter->GetOutputIJKToRASMatrix(), ijkToWorld);
  auto volume = volumeFor(scene, output, model, " resampled");
  setProvenance(volume, model);
  setVolume(volume, filter->GetOutput(), ijkToWorld);
  return volume;
}

vtkSmartPointer<vtkMRMLScalarVolumeNode> resampleLike(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                      vtkMRMLVolumeNode* reference,
                                                      vtkMRMLScalarVolumeNode* output) {
  if (!reference) throw Error(ErrorCode::InvalidArgument, "There is no reference volume: choose one.");
  if (output == reference)
    throw Error(ErrorCode::InvalidArgument, "The output is the reference as well: choose another.");
  const Alive alive(model, output, reference);
  vtkNew<vtkInnerGSResample> filter;
  filter->SetModel(modelOf(model));
  const GridGeometry grid = gridOf(reference); // throws if sheared
  vtkNew<vtkMatrix4x4> toModel, referenceToWorld, ijkToModel;
  refuseBend(model);
  fromWorld(model, toModel);
  vtk::toMatrix(grid, referenceToWorld); // from the first voxel, whatever its index
  vtkMatrix4x4::Multiply4x4(toModel, referenceToWorld, ijkToModel);
  refuseShear(model, ijkToModel);
  int size[3];
  reference->GetImageData()->GetDimensions(size);
  filter->SetReferenceGrid(ijkToModel, size[0], size[1], size[2]);
  filter->GeometryInImageOff();
  run(filter);
  auto volume = volumeFor(scene, output, model, " resampled");
  setProvenance(volume, model);
  setVolume(volume, filter->GetOutput(), referenceToWorld, reference);
  return volume;
}

} // namespace innergs::mrml
