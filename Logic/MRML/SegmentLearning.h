#pragma once
#include "Core/Features/FeatureTraining.h"
#include "JobSetup.h"

class vtkMRMLNode;

namespace innergs::mrml {

/// A task that teaches a model the segments of a segmentation or label map node; what the worker needs of the
/// nodes is copied here. sparse: slices without any label between labelled ones were not labelled. Throws
/// Error.
std::shared_ptr<Task> prepareLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse,
                                      vtkMRMLScene* scene);

/// The labels of such a node in the model's own coordinates (LPS), to be called once on any thread. Throws
/// Error, and so does what is returned.
std::function<NamedLabels(const std::stop_token&)> labelsLater(vtkMRMLInnerGSModelNode* model,
                                                               vtkMRMLNode* labels, vtkMRMLScene* scene);

} // namespace innergs::mrml
