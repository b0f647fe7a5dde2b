#pragma once
#include "Core/Base/Failure.h"
#include "Core/Job/JobOutline.h"
#include "Evaluation/JudgedReconstruction.h"
#include "IO/RecoveredFit.h"
#include "vtkInnerGSReconstruct.h"

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLTableNode;
class vtkMRMLVolumeNode;
class vtkSlicerInnerGSJob;

namespace innergs::mrml {

class SegmentationMask;
class DetachedTasks;
class DynamicWork;
class OutlineMask;

/// The filter, which also judges its quality by protocol H, with its settings open to this layer.
class JobFilter : public vtkInnerGSReconstruct {
public:
  static JobFilter* New();
  vtkTypeMacro(JobFilter, vtkInnerGSReconstruct);
  using vtkInnerGSReconstruct::WithOutline;
  /// Masks from segmentations, which the worker makes before the fit; null for those among the filter's own
  /// masks. `unstoppable` runs what cannot be stopped.
  std::vector<std::unique_ptr<SegmentationMask>> masks;
  DetachedTasks* unstoppable = nullptr;
  /// See JudgedReconstruction.
  std::optional<int> keepEvery;
  std::optional<EvaluationReport> quality;
  /// A model file to continue, read by the worker; empty: none.
  std::filesystem::path resumeFile;
  /// Called on the worker.
  ProgressCallback told;

protected:
  JobFilter();
  ~JobFilter() override;
  ReconstructionResult Reconstruct(ReconstructionInput&& input, const Settings& settings,
                                   const std::stop_token& stop) override;
  void ReportProgress(const innergs::Progress& progress) override;
};

/// A reconstruction, or other work on a model, that the worker can do without looking at a node.
struct Task {
  vtkSmartPointer<vtkSlicerInnerGSJob> job; // for the main thread alone
  vtkSmartPointer<JobFilter> filter;        // holds the snapshot; null for other work and dynamic scans
  // Other work: `work` runs on the worker and may throw Error; `deliver` then shows its result, on the main
  // thread.
  std::function<void(const std::stop_token&, DetachedTasks&, const ProgressCallback&)> work;
  std::function<void()> deliver;
  std::shared_ptr<DynamicWork> dynamic; // of a dynamic scan
  std::stop_source stop;

  // What the worker found.
  Failure failure; // no sentence: none
  bool cancelled = false;
  bool judging = false; // the fit is complete: a cancel now ends only the judging
  std::optional<EvaluationReport> report;

  // The state of a fit that is ended from outside: a description of the job, the folder and the file.
  std::atomic<bool> keep{false}; // set before the stop
  RecoveredFit recovered;        // without a file: not kept
  std::filesystem::path recoveryFolder;
  Failure notKept;

  // For the main thread, when it is done.
  bool discard = false; // the result is no longer wanted
  std::vector<std::string> inputNames;
  std::string maskName; // names, separated by "; "; "" without a mask
  bool newVolume = true, newModel = true, newTable = true,
       newUncertainty = true; // none was chosen at the start
  vtkWeakPointer<vtkMRMLScene> scene;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> parameters;
  vtkWeakPointer<vtkMRMLVolumeNode> firstInput;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> volume, uncertainty;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> model;
  vtkWeakPointer<vtkMRMLTableNode> table;
};

/// The names, separated by "; ".
std::string joined(const std::vector<std::string>& names);

/// Writes the state of the task's fit, or its result, to its recovery folder: once, and only if there is one;
/// on the thread that the task belongs to. Does not throw.
void keepFit(Task& task);
/// Removes the file that the task continued, if it is a recovered one: a newer state exists.
void dropResumedFile(const Task& task);

/// The slice thickness (mm) of an input for which 0 is set; 0: the distance between slices.
using ThicknessOf = std::function<double(vtkMRMLVolumeNode*)>;

/// Checks everything that needs no voxels; returns the configured filter. Throws Error.
vtkSmartPointer<JobFilter> check(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                                 const ThicknessOf& thicknessOf);

/// Where a job with these settings will run, and why.
std::string describeDevice(vtkMRMLInnerGSParameterNode* parameters);

/// The outline of the job and its quality table; it refers to no nodes, so any thread may use it. Throws
/// Error.
JobOutline outlineOf(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                     const ThicknessOf& thicknessOf, std::vector<OutlineMask>& masks);

/// check(), and copies the voxels; without `copy`, the worker copies them later from images that share them
/// with the nodes. Throws Error.
std::shared_ptr<Task> prepare(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                              const ThicknessOf& thicknessOf, bool copy);

} // namespace innergs::mrml
