#pragma once
#include "Core/Base/Failure.h"
#include "Core/Job/MemoryEstimate.h"
#include "Evaluation/JudgedReconstruction.h"
#include "vtkInnerGSReconstruct.h"

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

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

/// The filter with its settings open to this layer, which also judges its quality by protocol H.
class JobFilter : public vtkInnerGSReconstruct {
public:
  static JobFilter* New();
  vtkTypeMacro(JobFilter, vtkInnerGSReconstruct);
  using vtkInnerGSReconstruct::MakeSettings;
  using vtkInnerGSReconstruct::WithOutline;
  /// Made on the worker, before the fit, with what its parts may leave behind.
  std::unique_ptr<SegmentationMask> mask;
  DetachedTasks* unstoppable = nullptr;
  /// See JudgedReconstruction.
  std::optional<int> keepEvery;
  std::optional<EvaluationReport> quality;
  /// Called on the worker.
  ProgressCallback told;

protected:
  JobFilter();
  ~JobFilter() override;
  ReconstructionResult Reconstruct(ReconstructionInput&& input, const Settings& settings,
                                   const std::stop_token& stop) override;
  void ReportProgress(const innergs::Progress& progress) override;
};

/// A reconstruction that the worker can do without looking at a node.
struct Task {
  vtkSmartPointer<vtkSlicerInnerGSJob> job; // for the main thread alone
  vtkSmartPointer<JobFilter> filter;        // holds the snapshot
  std::stop_source stop;

  // What the worker found.
  Failure failure; // no sentence: none
  bool cancelled = false;
  bool judging = false; // the fit is complete: who cancels now only ends the judging of its quality
  std::optional<EvaluationReport> report;

  // For the main thread, when it is done.
  bool discard = false;                                    // nobody wants the result any more
  std::string inputNames, maskName;                        // "" without a mask
  bool newVolume = true, newModel = true, newTable = true; // none was chosen at the start
  vtkWeakPointer<vtkMRMLScene> scene;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> parameters;
  vtkWeakPointer<vtkMRMLVolumeNode> firstInput;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> volume;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> model;
  vtkWeakPointer<vtkMRMLTableNode> table;
};

/// What 0 leads to as an input's slice thickness: mm, 0 for the distance between slices.
using ThicknessOf = std::function<double(vtkMRMLVolumeNode*)>;

/// Everything that can be checked without looking at voxels; the filter as configured. Throws Error.
vtkSmartPointer<JobFilter> check(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                                 const ThicknessOf& thicknessOf);

/// Where a job with these settings will run, and why.
std::string describeDevice(vtkMRMLInnerGSParameterNode* parameters);

/// What a job will fit, without voxels: the job itself, and for its quality table. Knows no nodes: for any
/// thread.
struct Outline {
  Settings settings;
  std::vector<ReconstructionInput> fits;
  double seconds() const; // roughly; 0: unknown. May throw Error
  /// Where it will run, and why; "" and the sentence with which that is refused.
  std::string device(std::string& refusal) const;
  MemoryNeed memory() const;
  std::string key() const; // the same for what is estimated alike
};
/// Throws Error.
Outline outlineOf(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                  const ThicknessOf& thicknessOf);

/// check() and the one copy of the voxels; without it the worker makes it, from voxels shared with the nodes.
/// Throws Error.
std::shared_ptr<Task> prepare(vtkMRMLInnerGSParameterNode* parameters, vtkMRMLScene* scene,
                              const ThicknessOf& thicknessOf, bool copy);

} // namespace innergs::mrml
