#ifndef vtkInnerGSReconstruct_h
#define vtkInnerGSReconstruct_h

#include "vtkCommand.h" // vtkCommand::UserEvent
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSSettingsMacro.h"

#include <vector> // std::vector

class vtkDoubleArray;
class vtkImageData;
class vtkMatrix4x4;
class vtkTable;
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

/// Fits a continuous model to one or several scans and renders it on a grid.
///
/// Inputs: port 0, one or several scalar vtkImageData (any numeric type; AddInputData), each with an IJK→RAS
/// matrix; port 1, no mask image, one for all inputs or one per input. Outputs: port 0, vtkInnerGSModel; port
/// 1, vtkImageData (float, scanner units); port 2, empty unless EstimateUncertainty is on, vtkImageData on
/// the same grid: scalars "StandardDeviation" (float, scanner units) and point data "Measured" (unsigned
/// char, 0 where no slice measured anything). Inputs are never modified; their relevant voxels are copied
/// once.
///
/// ProgressEvent: see GetProgress(), GetProgressText() and the getters under "State of the fit".
/// PreviewEvent: a coarse rendering (vtkImageData as call data) from time to time, only if it is observed.
/// The thread that called Update() invokes the events.
class VTKINNERGS_EXPORT vtkInnerGSReconstruct : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSReconstruct* New();
  vtkTypeMacro(vtkInnerGSReconstruct, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum Events { PreviewEvent = vtkCommand::UserEvent + 1871 };
  enum SliceProfiles { PointProfile, BoxProfile, GaussianProfile };
  /// State of judging the quality by a second fit, like innergs::Judging; the outputs are complete
  /// anyway.
  enum QualityStates { QualityNotAsked, QualityMeasured, QualityStopped, QualityFailed };

  ///@{
  /// For the index-th input of port 0 (in the order of adding): IJK → RAS (mm), copied; null (default): from
  /// the image's origin, spacing and direction. Matrices may be left-handed, but not sheared. I, J, K are the
  /// image's structured coordinates.
  void SetInputIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS);
  vtkMatrix4x4* GetInputIJKToRASMatrix(int index);
  /// mm; 0 (default): the slice distance.
  void SetInputSliceThickness(int index, double thickness);
  double GetInputSliceThickness(int index);
  /// How a slice averages across its thickness; default BoxProfile.
  void SetInputSliceProfile(int index, int profile);
  int GetInputSliceProfile(int index);
  /// Which index axis counts the slices: 0, 1, 2 (default, K).
  void SetInputSliceAxis(int index, int axis);
  int GetInputSliceAxis(int index);
  /// A rigid map per slice (RAS mm), applied after IJK → RAS: 16 components, row by row, and a tuple per
  /// slice; kept by reference (after changes: Modified()). For slices that lie anywhere: tracked ultrasound, a tilted gantry, uneven
  /// distances. Null (default): none. Such inputs take no part in the alignment of several inputs.
  void SetInputSlicePoses(int index, vtkDoubleArray* poses);
  vtkDoubleArray* GetInputSlicePoses(int index);
  /// The name for messages and warnings.
  void SetInputName(int index, const std::string& name);
  std::string GetInputName(int index);
  ///@}
  /// Disconnects all inputs and masks, and clears their properties.
  void ClearInputs();

  ///@{
  /// Fits only voxels where the mask is non-zero. It may be on any grid, with its own IJK→RAS matrix
  /// (null: from the image). Null image: no mask. AddMaskData(): one mask per input, in their order, each
  /// with the matrix of its index.
  void SetMaskData(vtkImageData* mask);
  void AddMaskData(vtkImageData* mask);
  void SetMaskIJKToRASMatrix(vtkMatrix4x4* ijkToRAS);
  void SetMaskIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS);
  ///@}

  ///@{
  /// Fits only inside this RAS box (xmin, xmax, ymin, ymax, zmin, zmax; mm) plus a margin of two slices and,
  /// if no grid is given, restricts the output to the box. Off by default.
  vtkSetVector6Macro(Region, double);
  vtkGetVector6Macro(Region, double);
  vtkSetMacro(UseRegion, bool);
  vtkGetMacro(UseRegion, bool);
  vtkBooleanMacro(UseRegion, bool);
  /// Rotates the box: its bounds are in a frame that this matrix, copied, maps to RAS. Null (default): RAS.
  /// The output then covers the box along the first input's axes.
  void SetRegionToRASMatrix(vtkMatrix4x4* regionToRAS);
  vtkMatrix4x4* GetRegionToRASMatrix();
  ///@}

  ///@{
  /// The output grid. By default isotropic at the finest spacing of all inputs over the first one's box.
  /// OutputSpacing: mm along the first input's axes over its box; 0, 0, 0 (default): the grid described
  /// above.
  vtkSetVector3Macro(OutputSpacing, double);
  vtkGetVector3Macro(OutputSpacing, double);
  /// A given grid (overrides OutputSpacing): IJK→RAS, copied, and voxels along I, J, K. Null matrix: none.
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);
  /// Likewise from an image; ijkToRAS null: from its origin, spacing and direction. Null image: none.
  void SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS = nullptr);
  bool HasReferenceGrid();
  ///@}

  ///@{
  /// Settings: each as text by its name in Docs/settings.md, common ones also as numbers. They include
  /// Device, NumberOfThreads and InstructionSet.
  vtkInnerGSSettingsMacro();
#ifndef __VTK_WRAP__
  innergs::Settings GetSettings() const;
  void SetSettings(const innergs::Settings& settings);
#endif
  /// Share of each input's slices to hold out from a second fit, which takes about as long again, to report
  /// the quality on them; 0 (default) to 0.5. The outputs are fitted to all slices.
  vtkSetMacro(HeldOutFraction, double);
  vtkGetMacro(HeldOutFraction, double);
  /// Also estimates how far the volume may be off: the truth lies within 1.645 standard deviations of it in
  /// 90 % of the voxels. Takes that second fit (with a fraction of 0.2 if none is set) and two small ones. A
  /// warning says so if too little is known. Off by default.
  vtkSetMacro(EstimateUncertainty, bool);
  vtkGetMacro(EstimateUncertainty, bool);
  vtkBooleanMacro(EstimateUncertainty, bool);
  /// Resumes from this model (kept by reference); null: starts from scratch.
  void SetResumeModel(vtkInnerGSModel* model);
  vtkInnerGSModel* GetResumeModel();
  /// When stopped, outputs the model fitted so far (to resume from; no volume) instead of nothing. Off by
  /// default.
  vtkSetMacro(KeepModelWhenAborted, bool);
  vtkGetMacro(KeepModelWhenAborted, bool);
  vtkBooleanMacro(KeepModelWhenAborted, bool);
  ///@}

  /// Copies the inputs' voxels now, on this thread, and disconnects inputs and masks. The next Update() uses
  /// up this snapshot, on any thread, without touching the images. Returns false after an error.
  bool TakeSnapshot();
  bool HasSnapshot();
  ///@{
  /// Estimates before the start, without looking at voxels. 0 without inputs or after an error.
  /// Bytes of memory that the reconstruction needs beyond its inputs.
  vtkTypeInt64 EstimateMemory();
  /// Rough duration in seconds, from a small fit of the same kind (some tens of milliseconds at the first
  /// call); for a device other than the CPU, from the last fit there, 0 before the first one.
  double EstimateSeconds();
  /// The device that Device resolves to, regardless of memory, and why, as a sentence ("On the CPU. There is
  /// no GPU plugin ..."); the error message if it is not available.
  std::string DescribeDevice();
  ///@}

  vtkInnerGSModel* GetOutputModel();
  vtkImageData* GetOutputImage();
  vtkImageData* GetOutputStandardDeviation();
  /// The matrix of the output images; the identity before the first execution. May be called from any thread
  /// that may call the filter.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();
  /// The matrix of the image sent with the last PreviewEvent.
  vtkMatrix4x4* GetPreviewIJKToRASMatrix();
  vtkImageData* GetPreviewImage();

  ///@{
  /// State of the fit, for observers of ProgressEvent and after the end.
  std::string GetPhase();             // "Preparing", "Fitting", ...
  vtkGetMacro(CurrentIteration, int); // while the quality is measured, of the second fit
  vtkGetMacro(TotalIterations, int);
  vtkGetMacro(CurrentLoss, double);  // of the last iteration, normalised intensity units
  vtkGetMacro(TrainingPSNR, double); // dB, fitted samples; NaN: unknown
  vtkGetMacro(HeldOutPSNR,
              double); // dB on held-out slices of a second fit that did not see them; NaN: unknown
  vtkGetMacro(NumberOfHeldOutSlices, int); // over all inputs
  vtkGetMacro(QualityState, int);
  vtkGetMacro(CurrentGaussians, vtkIdType);
  vtkGetMacro(ElapsedSeconds, double);
  vtkGetMacro(RemainingSeconds, double);    // estimated
  vtkGetMacro(AgreementNote, std::string);  // sentences: how well several scans agree; "": one scan
  vtkGetMacro(PredictionNote, std::string); // sentence: what was put between the slices; "": nothing
  vtkGetMacro(ProfileNote, std::string);    // sentence: how thick the slices look; "": unknown
  vtkGetMacro(DeviceNote, std::string);     // sentence: where the fit runs and why; "" if not known yet
  ///@}

  ///@{
  /// Results of the last successful execution.
  vtkGetMacro(FitSeconds, double);
  /// The share of held-out voxels inside the 90 % intervals, which were not learned from them; NaN: unknown.
  vtkGetMacro(UncertaintyCoverage, double);
  vtkGetMacro(UncertaintyNote, std::string); // a sentence on that, "" without an estimate
  vtkGetMacro(Noise, double);                // estimated, scanner units
  vtkGetMacro(NumberOfNonFiniteVoxels, vtkIdType);
  int GetNumberOfWarnings();
  std::string GetWarning(int index); // a sentence for the user
  /// Where the slices of several scans were found to lie, a row each: Scan (from 1), Slice (from 0), Weight
  /// (0: left out), Gain, Displacement (mm), Angle (degrees), Residual (scanner units; NaN: unknown), and M00
  /// to M23, rigid, RAS mm: from where the header puts the slice to where it lies. Empty if slice motion was
  /// not estimated.
  vtkTable* GetSliceTable();
  vtkGetMacro(SlicesMoved, bool); // whether any motion was found
  /// "name=value" pairs separated by "; ": every setting as used, including chosen ones.
  vtkGetMacro(UsedSettings, std::string);
  vtkGetMacro(UsedInstructionSet, std::string);
  vtkGetMacro(UsedDevice, std::string); // where the fit ended: "cpu", "cuda:N"
  ///@}

protected:
  vtkInnerGSReconstruct();
  ~vtkInnerGSReconstruct() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;

  template <class Change>
  void ChangeInput(int index, Change change);
  void SetSettingNumber(const char* name, double number);
  double GetSettingNumber(const char* name);
  std::vector<vtkImageData*> GetInputImages(int port);
  innergs::vtk::OutputChoice MakeOutputChoice();
  innergs::ReconstructionInput MakeInput(const std::vector<vtkImageData*>& images,
                                         const std::vector<vtkImageData*>& masks, std::stop_token stop);
  /// Uses the snapshot, or what is known of the inputs without their voxels. Returns false without inputs.
  /// May throw.
  bool WithOutline(const std::function<void(const innergs::ReconstructionInput&)>& use);
  /// Runs the reconstruction on the thread that called Update(), calling ReportProgress() and
  /// ReportPreview(). May throw.
  virtual innergs::ReconstructionResult Reconstruct(innergs::ReconstructionInput&& input,
                                                    const innergs::Settings& settings,
                                                    const std::stop_token& stop);
  virtual void ReportProgress(const innergs::Progress& progress);
  void ReportPreview(const innergs::Volume& volume);
#endif

  double Region[6] = {0, 0, 0, 0, 0, 0};
  bool UseRegion = false;
  double OutputSpacing[3] = {0, 0, 0};
  double HeldOutFraction = 0;
  bool EstimateUncertainty = false, KeepModelWhenAborted = false, SlicesMoved = false;
  int CurrentIteration = 0, TotalIterations = 0, NumberOfHeldOutSlices = 0, QualityState = QualityNotAsked;
  double CurrentLoss = 0, TrainingPSNR, HeldOutPSNR, ElapsedSeconds = 0, RemainingSeconds = 0;
  vtkIdType CurrentGaussians = 0, NumberOfNonFiniteVoxels = 0;
  double FitSeconds = 0, Noise = 0, UncertaintyCoverage;
  std::string UsedSettings, UsedInstructionSet, UsedDevice, AgreementNote, PredictionNote, ProfileNote,
      DeviceNote, UncertaintyNote;

private:
  vtkInnerGSReconstruct(const vtkInnerGSReconstruct&) = delete;
  void operator=(const vtkInnerGSReconstruct&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
