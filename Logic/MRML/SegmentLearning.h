#pragma once
#include "Core/Features/FeatureTraining.h"
#include "JobSetup.h"

class vtkMRMLNode;
class vtkMRMLVolumeNode;

namespace innergs::mrml {

/// A task that teaches a model the segments of a segmentation or labelmap node; what the worker needs of the
/// nodes is copied here. sparse: slices without any label between labelled ones count as unlabelled. Throws
/// Error.
std::shared_ptr<Task> prepareLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse,
                                      vtkMRMLScene* scene);

/// Likewise from a volume node with several values per voxel and a JSON file with the embeddings of texts in
/// it (readTextEmbeddings()). Throws Error.
std::shared_ptr<Task> prepareFeatureLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLVolumeNode* features,
                                             const std::string& textsFile, vtkMRMLScene* scene);

/// A network in an ONNX file (networkTeacher()), which sees the model's own image.
struct NetworkTeacher {
  std::string file;
  std::vector<std::string> names; // of channels 1, 2, …; or
  std::string textsFile;          // embeddings of texts among its features
  double range[2] = {0, 0};       // values that become 0 and 1; equal: mean 0 and standard deviation 1
  double spacing = 0;             // of the voxels that it expects, mm; 0: as in the fit
};
std::shared_ptr<Task> prepareNetworkLearning(vtkMRMLInnerGSModelNode* model, const NetworkTeacher& network,
                                             vtkMRMLScene* scene);

/// Returns a function, to be called once on any thread, that gives the labels of such a node in the model's
/// own coordinates (LPS). Both throw Error.
std::function<NamedLabels(const std::stop_token&)> labelsLater(vtkMRMLInnerGSModelNode* model,
                                                               vtkMRMLNode* labels, vtkMRMLScene* scene);

} // namespace innergs::mrml
