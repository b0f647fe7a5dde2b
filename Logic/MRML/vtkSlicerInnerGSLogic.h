#ifndef vtkSlicerInnerGSLogic_h
#define vtkSlicerInnerGSLogic_h

#include "vtkSlicerInnerGSModuleLogicExport.h"
#include "vtkSlicerModuleLogic.h"

#include <vtkCommand.h> // vtkCommand::UserEvent

#include <functional> // std::function
#include <memory>     // std::unique_ptr
#include <stop_token> // std::stop_token
#include <string>     // returned

class vtkCollection;
class vtkDoubleArray;
class vtkFloatArray;
class vtkMatrix4x4;
class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLSegmentationNode;
class vtkMRMLSequenceNode;
class vtkMRMLSliceNode;
class vtkMRMLTableNode;
class vtkMRMLVolumeNode;
class vtkPoints;
class vtkSlicerInnerGSDynamicRequest;
class vtkSlicerInnerGSJob;
class vtkStringArray;
class vtkTable;
#ifndef __VTK_WRAP__
namespace innergs {
struct JobForecast;
struct MadeSegments;
struct NamedLabels;
} // namespace innergs
#endif

/// Reconstructs volumes into continuous models and looks at them.
///
/// Work runs on one worker thread over a snapshot of the inputs, job after job; nodes are touched and events
/// invoked on the main thread alone (the one that created the logic). In the Slicer application its event
/// loop delivers them. Without an application (slicer-core, notebooks, scripts that keep the main thread
/// busy) call ProcessPendingEvents() from time to time, or WaitForJob().
///
/// A failure invokes an ErrorEvent with one sentence that says what to do, GetLastError(), and leaves all
/// nodes as they were.
class VTK_SLICER_INNERGS_MODULE_LOGIC_EXPORT vtkSlicerInnerGSLogic : public vtkSlicerModuleLogic {
public:
  static vtkSlicerInnerGSLogic* New();
  vtkTypeMacro(vtkSlicerInnerGSLogic, vtkSlicerModuleLogic);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The call data is the vtkSlicerInnerGSJob. Every job ends with exactly one of the last three; when the
  /// logic itself is deleted, its jobs become Cancelled without an event.
  enum Events {
    JobStartedEvent = vtkCommand::UserEvent + 18710,
    JobProgressEvent,
    JobPreviewEvent, // GetPreviewImage() is new; of a dynamic scan GetPreviewModel()
    JobFinishedEvent,
    JobFailedEvent,
    JobCancelledEvent
  };

  ///@{
  /// Reconstruct with the parameter node's choices. Blocking: false after an error or a cancel; events are
  /// delivered while it waits. GetLastJob() has the details.
  bool Reconstruct(vtkMRMLInnerGSParameterNode* parameters);
  /// Non-blocking: checks everything, copies the inputs' voxels and returns; the job runs after those before
  /// it. Null when it was refused. If the mask is a segmentation, its labelmaps are copied here; the worker
  /// merges them, or makes them from its surfaces. copyVoxels off: returns at once, and the worker makes the
  /// copy first (phase "Preparing"): until then voxels must not be changed in place, but nodes may be
  /// removed. A job that has to wait for others copies now.
  vtkSlicerInnerGSJob* StartReconstruction(vtkMRMLInnerGSParameterNode* parameters, bool copyVoxels = true);
  /// Reconstructs a dynamic scan as a continuous volume in space and time: model node (GetModelNode(), its
  /// time is vtkMRMLInnerGSModelNode::SetTime()), frames as a sequence with its browser, quality table.
  /// Non-blocking, with the same jobs and events. Null when it was refused.
  vtkSlicerInnerGSJob* StartDynamicReconstruction(vtkSlicerInnerGSDynamicRequest* request);
  /// The same, blocking.
  bool ReconstructDynamic(vtkSlicerInnerGSDynamicRequest* request);
  /// While a dynamic scan is fitted: the model so far (GetPreviewModel()) at a time in s as a volume node,
  /// `output` or a new one; null after an error, also before the first JobPreviewEvent.
  vtkMRMLScalarVolumeNode* PreviewFrame(vtkSlicerInnerGSJob* job, double seconds,
                                        vtkMRMLScalarVolumeNode* output = nullptr);
  /// The sentence with which it would be refused, judging by grids, times and types alone; else "".
  std::string CheckDynamicRequest(vtkSlicerInnerGSDynamicRequest* request);
  /// Transform nodes of a table of slices (vtkSlicerInnerGSJob::GetSliceTableNode()), one per row, in a
  /// folder beside it: to its parent, RAS mm, from where the scan's header puts the slice to where it lies.
  /// They are added to `transforms`, which may be null. False after an error.
  bool CreateSliceTransforms(vtkMRMLTableNode* slices, vtkCollection* transforms = nullptr);
  /// Ends a job, or all (null), queued and running, and waits for it: within 200 ms it is Cancelled, or
  /// Finished if it already was. Slicer's conversion of surfaces to voxels cannot be stopped and ends on its
  /// own; the logic's destruction waits for that.
  void Cancel(vtkSlicerInnerGSJob* job = nullptr);
  /// The same without waiting, for programs whose event loop delivers events.
  void RequestCancel(vtkSlicerInnerGSJob* job = nullptr);
  /// Whether a job is queued or running. Delivers pending events on the main thread, so that a polling loop
  /// comes to an end.
  bool IsRunning();
  /// The running job or the next to run; null when there is none.
  vtkSlicerInnerGSJob* GetCurrentJob();
  /// The job that was started last, done or not.
  vtkSlicerInnerGSJob* GetLastJob();
  /// Queued and running.
  int GetNumberOfJobs();
  /// Delivers events until the job (null: all jobs) is done, for at most `seconds` (below 0: for ever).
  /// Returns whether it is done.
  bool WaitForJob(vtkSlicerInnerGSJob* job = nullptr, double seconds = -1);
  /// Delivers the worker's updates since the last call; returns how many. On the main thread only.
  int ProcessPendingEvents();
  ///@}

  /// The sentence of the last error; "" when the last call went well.
  std::string GetLastError();
  /// Its kind, one of vtkInnerGSAlgorithm::ErrorCodes; 0 when the last call went well.
  int GetLastErrorCode();
  /// The sentence with which a reconstruction would be refused, "" when it can start. Voxels are not looked
  /// at.
  std::string CheckParameters(vtkMRMLInnerGSParameterNode* parameters);
  ///@{
  /// Before the start, without looking at voxels; 0 when it would be refused.
  /// Bytes of memory that a reconstruction will need beyond its inputs.
  vtkTypeInt64 EstimateMemory(vtkMRMLInnerGSParameterNode* parameters);
  /// Roughly the seconds that it will take, the quality table included. The first call for given settings and
  /// spacings times a small fit (some tens of milliseconds). On a device other than the CPU: 0 (unknown)
  /// before the first fit there.
  double EstimateSeconds(vtkMRMLInnerGSParameterNode* parameters);
  /// Where it will run, memory aside, and why, as a sentence; "" without parameters.
  std::string DescribeDevice(vtkMRMLInnerGSParameterNode* parameters);
#ifndef __VTK_WRAP__
  /// Returns a function, for any thread, that finds the seconds and the device for the parameters as they are
  /// now; empty if these are refused. key: JobOutline's.
  std::function<innergs::JobForecast()> EstimateLater(vtkMRMLInnerGSParameterNode* parameters,
                                                      std::string* key);
#endif
  ///@}

  ///@{
  /// The model's value (scanner units) at points in the world (RAS mm). Outside the model: 0, or what air has
  /// in its units. NaN, or false and an empty array, after an error.
  double GetValueAtRAS(vtkMRMLInnerGSModelNode* model, double r, double a, double s);
  bool GetValuesAtRAS(vtkMRMLInnerGSModelNode* model, vtkPoints* points, vtkFloatArray* values);
  ///@}

  ///@{
  /// The model as a volume node, `output` or a new one; null after an error.
  /// On a plane: planeToRAS (copied) as a slice node's SliceToRAS, its origin in the middle of columns × rows
  /// pixels of `spacing` mm.
  vtkMRMLScalarVolumeNode* QueryPlane(vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* planeToRAS, int columns,
                                      int rows, double spacing, vtkMRMLScalarVolumeNode* output = nullptr);
  /// Likewise the standard deviation of its volume, where that was estimated. Point data "Measured" of the
  /// image: 0 where no slice measured anything.
  vtkMRMLScalarVolumeNode* QueryUncertaintyPlane(vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* planeToRAS,
                                                 int columns, int rows, double spacing,
                                                 vtkMRMLScalarVolumeNode* output = nullptr);
  /// On the fitted region, at an isotropic spacing in mm (0: as in the fit).
  vtkMRMLScalarVolumeNode* Resample(vtkMRMLInnerGSModelNode* model, double spacing = 0,
                                    vtkMRMLScalarVolumeNode* output = nullptr);
  /// On another volume's voxels.
  vtkMRMLScalarVolumeNode* ResampleLike(vtkMRMLInnerGSModelNode* model, vtkMRMLVolumeNode* reference,
                                        vtkMRMLScalarVolumeNode* output = nullptr);
  ///@}

  ///@{
  /// From a dynamic scan's model, as a sequence node (`output` or a new one with its browser): the frames at
  /// any times (s; null: those that it was fitted to), and its motion as grid transforms with the direction
  /// of displacement files: what lies at x at `from` (s; NaN: the frame in the middle) lies at x + d(x) at
  /// the transform's own time, so a frame under its transform looks as at `from`. Null after an error.
  vtkMRMLSequenceNode* CreateFrames(vtkMRMLInnerGSModelNode* model, vtkDoubleArray* times = nullptr,
                                    vtkMRMLSequenceNode* output = nullptr);
  vtkMRMLSequenceNode* CreateMotion(vtkMRMLInnerGSModelNode* model, vtkDoubleArray* times, double from,
                                    vtkMRMLSequenceNode* output = nullptr);
  ///@}

  ///@{
  /// A volume node that shows the model on a slice view's plane from now on, whenever the view or the model
  /// changes, until StopFollowing(), until something else is put into it here or one of the nodes is removed.
  /// At most MaximumFollowPixels a side; fewer while the view moves if these would take more than about 40
  /// ms, and all once it is at rest.
  vtkMRMLScalarVolumeNode* FollowSlice(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice,
                                       vtkMRMLScalarVolumeNode* output = nullptr);
  /// Null: all.
  void StopFollowing(vtkMRMLScalarVolumeNode* output = nullptr);
  bool IsFollowing(vtkMRMLScalarVolumeNode* output);
  vtkSetClampMacro(MaximumFollowPixels, int, 16, 8192);
  vtkGetMacro(MaximumFollowPixels, int);
  ///@}

  /// The Gaussians' centres with intensity, ellipsoid tensors and disagreement as a model node (`output` or a
  /// new one) for 3D views; at most `maximum` (0: all). Null after an error.
  vtkMRMLModelNode* CreateGaussianModel(vtkMRMLInnerGSModelNode* model, int maximum = 0,
                                        vtkMRMLModelNode* output = nullptr);

  ///@{
  /// Segments by name. First the model learns them, once, from a segmentation or a labelmap (names from its
  /// colour table) of the same patient. sparse: slices without any label between labelled ones count as
  /// unlabelled and follow the scan. Learning is a job like a reconstruction; its result is the model, which
  /// is saved with what it learned. Null or false after an error.
  vtkSlicerInnerGSJob* StartLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels,
                                     bool sparse = false);
  /// Blocking, as Reconstruct().
  bool LearnSegments(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse = false);
  /// From a volume node with several values per voxel instead, and a JSON file with the embeddings of texts
  /// in it: {"liver": [0.1, …], "spleen": […]}; "background" is everything else.
  vtkSlicerInnerGSJob* StartLearningFromFeatures(vtkMRMLInnerGSModelNode* model, vtkMRMLVolumeNode* features,
                                                 const std::string& textsFile);
  /// Or from a network in an ONNX file, which OpenVINO runs on the model's own image: see
  /// vtkInnerGSLearnSegments. names: of its channels 1, 2, …; null, with a file of texts: its channels are
  /// features. low, high: values that become 0 and 1; equal: mean 0 and standard deviation 1. spacing: of the
  /// voxels that it expects, mm; 0: as in the fit.
  vtkSlicerInnerGSJob* StartLearningFromNetwork(vtkMRMLInnerGSModelNode* model,
                                                const std::string& networkFile, vtkStringArray* names,
                                                const std::string& textsFile = "", double low = 0,
                                                double high = 0, double spacing = 0);
  /// For a dynamic scan's model, the following refer to its GetTime().
  /// What a text in words ("left kidney") asks for: one of vtkInnerGSSegment's Answers; −1 after an error.
  /// candidates (may be null): the segments that fit, best first, as columns Name, Score (0 to 1: how well
  /// the words fit) and Leading (1: those that answer the query together).
  int FindByText(vtkMRMLInnerGSModelNode* model, const std::string& text, vtkTable* candidates = nullptr);
  /// The answer to the last text as a sentence.
  std::string GetLastAnswer();
  /// The same as segments of `output`, or of a new segmentation node, with name, terminology and colour; a
  /// segment of that name is replaced. One for each leading candidate where side or number is open. Null
  /// after an error, also if the structure is unknown or not in this volume. threshold: of the probability
  /// (0: where the segment is the likeliest); minimumSize: of connected parts, mm³; smoothing: standard
  /// deviation, mm; spacing: of the voxels, mm (0: as in the fit). The first call for a model and spacing
  /// takes seconds, the next ones milliseconds.
  vtkMRMLSegmentationNode* SegmentByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                         vtkMRMLSegmentationNode* output = nullptr, double threshold = 0,
                                         bool largestOnly = false, double minimumSize = 0,
                                         double smoothing = 0, double spacing = 0);
  /// The probability of what a text asks for, 0 to 1, at every voxel of `output` or a new volume node, under
  /// the model's transform; for several segments, that of the likeliest. Null as SegmentByText().
  vtkMRMLScalarVolumeNode* ScoreByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                       vtkMRMLScalarVolumeNode* output = nullptr, double spacing = 0);
#ifndef __VTK_WRAP__
  /// For panels with a thread of their own: returns a function, for any thread, that gives the labels in the
  /// model's own coordinates (LPS), with their names, and throws innergs::Error. Empty after an error.
  std::function<innergs::NamedLabels(const std::stop_token&)> LabelsLater(vtkMRMLInnerGSModelNode* model,
                                                                          vtkMRMLNode* labels);
  /// Puts segments into `output` or a new segmentation node beside the model.
  vtkMRMLSegmentationNode* AddSegments(vtkMRMLInnerGSModelNode* model, const innergs::MadeSegments& segments,
                                       vtkMRMLSegmentationNode* output = nullptr);
#endif
  ///@}

  ///@{
  /// Model files: .innergs or .ply. Null or false after an error.
  vtkMRMLInnerGSModelNode* LoadModel(const std::string& fileName);
  bool SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName);
#ifndef __VTK_WRAP__
  /// The same without blocking the main thread: returns a function that reads or writes the file on any
  /// thread and returns another, to be called on the main thread, that completes the nodes.
  std::function<std::function<vtkMRMLInnerGSModelNode*()>()> LoadModelLater(const std::string& fileName);
  std::function<std::function<bool()>()> SaveModelLater(vtkMRMLInnerGSModelNode* model,
                                                        const std::string& fileName);
#endif
  ///@}

  ///@{
  /// Slice thickness in mm (0018,0050) from the DICOM files that a volume was read from, for which it needs a
  /// lookup, or SliceThickness in the BIDS file beside its NIfTI: used for 0 in the parameters if its slices
  /// lie along K. 0: unknown.
  double GetDicomSliceThickness(vtkMRMLVolumeNode* volume);
  /// In how many interleaved passes the slices along K were acquired, by the times in the same DICOM files or
  /// in that BIDS file: the number for Packets. 1: one after the other; 0:
  /// unknown, or in another order.
  int GetNumberOfInterleavedPasses(vtkMRMLVolumeNode* volume);
#ifndef __VTK_WRAP__
  /// The value of a tag ("0018,0050") of the instance with a SOP instance UID; "" when unknown. Called on the
  /// main thread.
  using DicomLookup = std::function<std::string(const std::string& instanceUID, const std::string& tag)>;
  void SetDicomLookup(DicomLookup lookup);
#endif
  ///@}

  ///@{
  /// The folder for the states of fits that something other than Cancel() ends: the scene is closed, the
  /// parameter node removed, the application ends. One model file each, the newest ten; see the job's
  /// GetRecoveryFile(). UTF-8; "": InnerGS-recovery in the application's temporary folder or, without an
  /// application, the system's.
  void SetRecoveryFolder(const std::string& folder);
  std::string GetRecoveryFolder();
  ///@}

  /// Its event loop delivers events; it may be deleted before the logic, with jobs running.
  void SetMRMLApplicationLogic(vtkMRMLApplicationLogic* application) override;

  static std::string GetVersion();

protected:
  vtkSlicerInnerGSLogic();
  ~vtkSlicerInnerGSLogic() override;

  void RegisterNodes() override;
  void SetMRMLSceneInternal(vtkMRMLScene* scene) override;
  void OnMRMLSceneStartClose() override;
  void OnMRMLSceneEndImport() override;
  void OnMRMLSceneNodeRemoved(vtkMRMLNode* node) override;

  int MaximumFollowPixels = 1024;

private:
  vtkSlicerInnerGSLogic(const vtkSlicerInnerGSLogic&) = delete;
  void operator=(const vtkSlicerInnerGSLogic&) = delete;

#ifndef __VTK_WRAP__
  struct Internals;
  friend struct Internals;
  std::unique_ptr<Internals> Work;
#endif
};

#endif
