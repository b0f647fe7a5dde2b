#pragma once
#include "Text/SegmentFinder.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <optional>

class vtkInnerGSModel;
class vtkMRMLInnerGSModelNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLSegmentationNode;

namespace innergs::mrml {

/// Segments of model nodes by name. Keeps the last model's probabilities, so that its next query takes
/// milliseconds. Main thread.
class SegmentQueries {
public:
  SegmentQueries();
  ~SegmentQueries();

  /// Throws Error(NoData) for a model that has learned no segments. encoded(): at a spacing in mm, 0: as in
  /// the fit.
  SegmentFinder& finder(vtkMRMLInnerGSModelNode* model);
  SegmentFinder& encoded(vtkMRMLInnerGSModelNode* model, double spacing);

  /// What a text asks for. Throws as finder() and interpret() do.
  SegmentAnswer ask(vtkMRMLInnerGSModelNode* model, const std::string& text, double spacing);
  /// The segments that it asks for. Throws as ask(), and Error(NoData) where it asks for none.
  MadeSegments made(vtkMRMLInnerGSModelNode* model, const std::string& text, double spacing,
                    const SegmentOptions& options = {});

  std::string answer; // the last one, as a sentence

private:
  vtkNew<vtkInnerGSModel> model_; // that the finder is for
  std::optional<SegmentFinder> finder_;
};

/// Adds segments to `output`, or to a new segmentation node beside the model and under its transform;
/// replaces a segment of the same name. Throws Error.
vtkSmartPointer<vtkMRMLSegmentationNode> addSegments(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                     const MadeSegments& made,
                                                     vtkMRMLSegmentationNode* output);

/// The probability of the requested segments (for several, that of the likeliest) as voxels of `output` or of
/// a new volume node beside the model and under its transform. Throws Error.
vtkSmartPointer<vtkMRMLScalarVolumeNode> addScore(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                  const MadeSegments& made, vtkMRMLScalarVolumeNode* output);

} // namespace innergs::mrml
