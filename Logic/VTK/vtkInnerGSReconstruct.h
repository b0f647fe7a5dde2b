#ifndef vtkInnerGSReconstruct_h
#define vtkInnerGSReconstruct_h

#include "vtkCommand.h" // vtkCommand::UserEvent
#include "vtkInnerGSAlgorithm.h"

#include <vector> // std::vector

class vtkImageData;
class vtkMatrix4x4;
#ifndef __VTK_WRAP__
namespace innergs {
struct Progress;
struct ReconstructionInput;
struct ReconstructionResult;
struct Settings;
struct Volume;
namespace vtk {
struct OutputChoice;
} // namespace vtk
} // namespace innergs
#endif

/// Fits a continuous model to one or several scans and puts it on a grid.
///
/// Inputs: port 0, one or several scalar vtkImageData (any numeric type; AddInputData), each with an IJK→RAS
/// matrix; port 1, an optional mask image. Outputs: port 0 vtkInnerGSModel, port 1 vtkImageData (float,
/// scanner units). Inputs are never modified, and of their voxels those that count are copied once.
///
/// ProgressEvent: GetProgress(), GetProgressText() and the getters under "State of the fit". PreviewEvent: a
/// coarse rendering (vtkImageData as call data) from time to time, made only when someone observes it. Events
/// are invoked by the thread that called Update().
class VTKINNERGS_EXPORT vtkInnerGSReconstruct : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSReconstruct* New();
  vtkTypeMacro(vtkInnerGSReconstruct, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum Events { PreviewEvent = vtkCommand::UserEvent + 1871 };
  enum Presets { Fast, Balanced, Best, Paper }; // Paper: the paper's Algorithm 1
  enum { Automatic = -1 };                      // chosen from preset and data
  enum Blendings { Normalised, Additive, Alpha };
  enum Losses { L1, L2, Huber };
  enum Initialisations { Adaptive, Grid };
  enum Schedules { Exponential, Plateau };
  enum Selections { ExactSelection, Method1, Method2 };
  enum SliceProfiles { PointProfile, BoxProfile, GaussianProfile };
  /// Of the judging of the quality by a second fit, as innergs::Judging: the outputs are complete anyway.
  enum QualityStates { QualityNotAsked, QualityMeasured, QualityStopped, QualityFailed };

  ///@{
  /// Of the index-th input of port 0 (in the order of adding): IJK → RAS (mm), copied; null (default): from
  /// the image's origin, spacing and direction. Left-handed matrices are fine, sheared ones an error. I, J, K
  /// are the image's structured coordinates.
  void SetInputIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS);
  vtkMatrix4x4* GetInputIJKToRASMatrix(int index);
  /// mm; 0 (default): the distance between slices.
  void SetInputSliceThickness(int index, double thickness);
  double GetInputSliceThickness(int index);
  /// How a slice averages across its thickness; BoxProfile by default.
  void SetInputSliceProfile(int index, int profile);
  int GetInputSliceProfile(int index);
  /// Which index axis counts the slices: 0, 1, 2 (default, K).
  void SetInputSliceAxis(int index, int axis);
  int GetInputSliceAxis(int index);
  /// For messages and warnings.
  void SetInputName(int index, const std::string& name);
  std::string GetInputName(int index);
  ///@}
  /// Disconnects all inputs and the mask, and forgets what was set for them.
  void ClearInputs();

  ///@{
  /// Only voxels where the mask is not zero are fitted. On any lattice, with its own IJK→RAS matrix (null:
  /// from the image). Null image: no mask.
  void SetMaskData(vtkImageData* mask);
  void SetMaskIJKToRASMatrix(vtkMatrix4x4* ijkToRAS);
  ///@}

  ///@{
  /// Fit only inside this RAS box (xmin, xmax, ymin, ymax, zmin, zmax; mm), a margin of two slices included,
  /// and, where no grid is given, put out only that part. Off by default.
  vtkSetVector6Macro(Region, double);
  vtkGetVector6Macro(Region, double);
  vtkSetMacro(UseRegion, bool);
  vtkGetMacro(UseRegion, bool);
  vtkBooleanMacro(UseRegion, bool);
  /// Turns the box: its bounds are in a frame that this matrix, copied, maps to RAS. Null (default): RAS. The
  /// output then covers the box, along the first input's axes.
  void SetRegionToRASMatrix(vtkMatrix4x4* regionToRAS);
  vtkMatrix4x4* GetRegionToRASMatrix();
  ///@}

  ///@{
  /// The output grid. By default isotropic at the finest spacing of all inputs over the first one's box.
  /// OutputSpacing: mm along the first input's axes over its box; 0, 0, 0 (default) for the choice above.
  vtkSetVector3Macro(OutputSpacing, double);
  vtkGetVector3Macro(OutputSpacing, double);
  /// A given grid (goes before OutputSpacing): IJK→RAS, copied, and voxels along I, J, K. Null matrix: none.
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);
  /// The same from an image; ijkToRAS null: from its origin, spacing and direction. Null image: none.
  void SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS = nullptr);
  bool HasReferenceGrid();
  ///@}

  ///@{
  /// Settings, as innergs::Settings explains them. Automatic (−1), or 0 for counts, stands for "chosen from
  /// preset and data" and is the default of most.
  vtkSetClampMacro(Preset, int, Fast, Paper);
  vtkGetMacro(Preset, int);
  vtkSetClampMacro(Blending, int, Automatic, Alpha);
  vtkGetMacro(Blending, int);
  vtkSetClampMacro(Selection, int, ExactSelection, Method2); // of the pixels a Gaussian is evaluated on
  vtkGetMacro(Selection, int);
  vtkSetMacro(NumberOfGaussians, vtkIdType);
  vtkGetMacro(NumberOfGaussians, vtkIdType);
  vtkSetMacro(NumberOfIterations, int); // iterations over the data, per member
  vtkGetMacro(NumberOfIterations, int);
  vtkSetMacro(EnsembleSize, int); // fields fitted independently and merged
  vtkGetMacro(EnsembleSize, int);
  vtkSetClampMacro(LinearIntensity, int, -1, 1); // Automatic, 0: off, 1: on
  vtkGetMacro(LinearIntensity, int);
  vtkSetClampMacro(Loss, int, Automatic, Huber);
  vtkGetMacro(Loss, int);
  vtkSetMacro(HuberDelta, double); // fraction of the intensity range
  vtkGetMacro(HuberDelta, double);
  vtkSetMacro(SSIMWeight, double); // below 0 (default): chosen
  vtkGetMacro(SSIMWeight, double);
  vtkSetClampMacro(Initialisation, int, Automatic, Grid);
  vtkGetMacro(Initialisation, int);
  vtkSetClampMacro(PaperStopRule, int, -1, 1);
  vtkGetMacro(PaperStopRule, int);
  vtkSetClampMacro(AllAxes, int, -1, 1); // fit the slices of one scan along all its axes
  vtkGetMacro(AllAxes, int);
  vtkSetClampMacro(Schedule, int, Automatic, Plateau); // of the learning rates
  vtkGetMacro(Schedule, int);
  vtkSetMacro(PlateauPatience, int); // Plateau: iterations without improvement before the rates fall
  vtkGetMacro(PlateauPatience, int);
  vtkSetMacro(PlateauFactor, double); // what they are multiplied by then
  vtkGetMacro(PlateauFactor, double);
  vtkSetMacro(PlateauLowest, double); // share of the first rates that they never fall below
  vtkGetMacro(PlateauLowest, double);
  vtkSetMacro(PlateauThreshold, double); // relative improvement of the loss that counts
  vtkGetMacro(PlateauThreshold, double);
  vtkSetMacro(DensifyEvery, int); // iterations; Automatic; 0: never
  vtkGetMacro(DensifyEvery, int);
  vtkSetMacro(MaximumNumberOfGaussians,
              vtkIdType); // that densification may reach; 0: as many as at the start
  vtkGetMacro(MaximumNumberOfGaussians, vtkIdType);
  vtkSetMacro(PruneOpacity, double); // densification prunes below it; below 0 (default): chosen
  vtkGetMacro(PruneOpacity, double);
  vtkSetMacro(PruneSize, double); // voxels: and above this standard deviation
  vtkGetMacro(PruneSize, double);
  vtkSetMacro(DensifyGradient, double); // Gaussians pulled harder become two, see innergs::DensifyThresholds
  vtkGetMacro(DensifyGradient, double);
  vtkSetMacro(SplitSize, double); // voxels squared: with a larger covariance they are split, else cloned
  vtkGetMacro(SplitSize, double);
  vtkSetMacro(PointWeight, double); // of the loss beside SSIM; below 0 (default): chosen
  vtkGetMacro(PointWeight, double);
  vtkSetMacro(Cutoff, double); // Mahalanobis radius of a Gaussian, 1 to 5; below 0 (default): chosen
  vtkGetMacro(Cutoff, double);
  vtkSetMacro(Beta1, double); // Adam's share of the old first moment, 0 to 1; below 0 (default): chosen
  vtkGetMacro(Beta1, double);
  vtkSetMacro(Beta2, double); // and of the second
  vtkGetMacro(Beta2, double);
  vtkSetMacro(Relocate, bool);
  vtkGetMacro(Relocate, bool);
  vtkBooleanMacro(Relocate, bool);
  vtkSetMacro(Consistency, bool); // data-consistency step after the fit
  vtkGetMacro(Consistency, bool);
  vtkBooleanMacro(Consistency, bool);
  vtkSetMacro(FillValue, double); // scanner units: the model's value outside a mask; 0 by default
  vtkGetMacro(FillValue, double);
  vtkSetMacro(Device, const std::string&); // "auto" (default): a GPU where it suffices; or "cpu", "cuda:N"
  vtkGetMacro(Device, std::string);
  vtkSetMacro(Seed, vtkTypeUInt64); // same seed, same result, bit for bit
  vtkGetMacro(Seed, vtkTypeUInt64);
  /// Share of each input's slices withheld from a second fit, which takes about the same time again, to
  /// report the quality on them; 0 (default) to 0.5. The outputs are fitted to all slices.
  vtkSetMacro(HeldOutFraction, double);
  vtkGetMacro(HeldOutFraction, double);
  /// Go on from this model (kept by reference); null: start anew.
  void SetResumeModel(vtkInnerGSModel* model);
  vtkInnerGSModel* GetResumeModel();
  /// When stopped, put out the model reached (to resume from; no volume) instead of nothing. Off by default.
  vtkSetMacro(KeepModelWhenAborted, bool);
  vtkGetMacro(KeepModelWhenAborted, bool);
  vtkBooleanMacro(KeepModelWhenAborted, bool);
  ///@}

  /// Copies the inputs' voxels now, on this thread, and disconnects inputs and mask: the next Update() works
  /// on the snapshot, from any thread, without touching the images, and uses it up. False after an error.
  bool TakeSnapshot();
  bool HasSnapshot();
  ///@{
  /// Before the start; voxels are not looked at. 0 without inputs or after an error.
  /// Bytes of memory that the reconstruction will need beyond its inputs.
  vtkTypeInt64 EstimateMemory();
  /// Roughly the seconds that it will take, from a small fit of the same kind (some tens of milliseconds, the
  /// first time); on another device than the CPU from the last fit there, 0 before the first one.
  double EstimateSeconds();
  /// Where Device leads, memory aside, and why, as a sentence ("On the CPU. There is no GPU plugin ..."). The
  /// sentence of the error where it cannot be had.
  std::string DescribeDevice();
  ///@}

  vtkInnerGSModel* GetOutputModel();
  vtkImageData* GetOutputImage();
  /// Of the output image; the identity before the first execution. Valid in any thread that may call the
  /// filter.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();
  /// Of the image that the last PreviewEvent handed out.
  vtkMatrix4x4* GetPreviewIJKToRASMatrix();
  vtkImageData* GetPreviewImage();

  ///@{
  /// State of the fit, for observers of ProgressEvent and after the end.
  std::string GetPhase();             // "Preparing", "Fitting", ...
  vtkGetMacro(CurrentIteration, int); // while the quality is judged, of the second fit
  vtkGetMacro(TotalIterations, int);
  vtkGetMacro(CurrentLoss, double);  // of the last iteration, normalised intensity units
  vtkGetMacro(TrainingPSNR, double); // dB, fitted samples; NaN: unknown
  vtkGetMacro(HeldOutPSNR,
              double); // dB on withheld slices, of a second fit that did not see them; NaN: unknown
  vtkGetMacro(NumberOfHeldOutSlices, int); // over all inputs
  vtkGetMacro(QualityState, int);
  vtkGetMacro(CurrentGaussians, vtkIdType);
  vtkGetMacro(ElapsedSeconds, double);
  vtkGetMacro(RemainingSeconds, double); // estimated
  std::string GetDeviceNote();           // where the fit runs and why, a sentence; "" before that is known
  ///@}

  ///@{
  /// About the last successful execution.
  vtkGetMacro(FitSeconds, double);
  vtkGetMacro(Noise, double); // estimated, scanner units
  vtkGetMacro(NumberOfNonFiniteVoxels, vtkIdType);
  int GetNumberOfWarnings();
  std::string GetWarning(int index); // a sentence for the user
  /// "name=value" pairs separated by "; ": every setting as it was used, with what was chosen filled in.
  std::string GetUsedSettings();
  std::string GetUsedInstructionSet();
  std::string GetUsedDevice(); // where the fit ended: "cpu", "cuda:N"
  ///@}

protected:
  vtkInnerGSReconstruct();
  ~vtkInnerGSReconstruct() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;

  innergs::Settings MakeSettings();
  innergs::vtk::OutputChoice MakeOutputChoice();
  innergs::ReconstructionInput MakeInput(const std::vector<vtkImageData*>& images, vtkImageData* mask,
                                         std::stop_token stop);
  /// The snapshot, or what is known of the inputs without their voxels; false without any. May throw.
  bool WithOutline(const std::function<void(const innergs::ReconstructionInput&)>& use);
  /// Makes the result, on the thread that called Update(), with ReportProgress() and ReportPreview() on the
  /// way. May throw.
  virtual innergs::ReconstructionResult Reconstruct(innergs::ReconstructionInput&& input,
                                                    const innergs::Settings& settings,
                                                    const std::stop_token& stop);
  virtual void ReportProgress(const innergs::Progress& progress);
  void ReportPreview(const innergs::Volume& volume);
#endif

  double Region[6] = {0, 0, 0, 0, 0, 0};
  bool UseRegion = false;
  double OutputSpacing[3] = {0, 0, 0};
  int Preset = Balanced, Blending = Automatic, Loss = Automatic, Initialisation = Automatic,
      LinearIntensity = Automatic;
  vtkIdType NumberOfGaussians = 0;
  int NumberOfIterations = 0, EnsembleSize = 0;
  double HuberDelta = 0.02, SSIMWeight = Automatic, HeldOutFraction = 0;
  int PaperStopRule = Automatic, AllAxes = Automatic, Schedule = Automatic, DensifyEvery = Automatic;
  vtkIdType MaximumNumberOfGaussians = 0;
  double PointWeight = Automatic;
  int Selection = ExactSelection, PlateauPatience = 10;
  double PlateauFactor = 0.5, PlateauLowest = 0.01, PlateauThreshold = 1e-4;
  double PruneOpacity = Automatic, PruneSize = 20, DensifyGradient = 1, SplitSize = 2;
  double Cutoff = Automatic, Beta1 = Automatic, Beta2 = Automatic, FillValue = 0;
  std::string Device = "auto";
  bool Relocate = true, Consistency = true, KeepModelWhenAborted = false;
  vtkTypeUInt64 Seed = 1;

  int CurrentIteration = 0, TotalIterations = 0, NumberOfHeldOutSlices = 0, QualityState = QualityNotAsked;
  double CurrentLoss = 0, TrainingPSNR, HeldOutPSNR, ElapsedSeconds = 0, RemainingSeconds = 0;
  vtkIdType CurrentGaussians = 0, NumberOfNonFiniteVoxels = 0;
  double FitSeconds = 0, Noise = 0;

private:
  vtkInnerGSReconstruct(const vtkInnerGSReconstruct&) = delete;
  void operator=(const vtkInnerGSReconstruct&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
