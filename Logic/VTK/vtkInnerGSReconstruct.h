#ifndef vtkInnerGSReconstruct_h
#define vtkInnerGSReconstruct_h

#include "vtkCommand.h" // vtkCommand::UserEvent
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSSettingsMacro.h"

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
  /// Settings: any of them by its name in Docs/settings.md as text, the usual ones as numbers too; Device,
  /// NumberOfThreads and InstructionSet are among them.
  vtkInnerGSSettingsMacro();
#ifndef __VTK_WRAP__
  innergs::Settings GetSettings() const;
  void SetSettings(const innergs::Settings& settings);
#endif
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
  vtkGetMacro(RemainingSeconds, double);    // estimated
  vtkGetMacro(PredictionNote, std::string); // what was put between one scan's slices, a sentence; "": nothing
  vtkGetMacro(DeviceNote, std::string);     // where the fit runs and why, a sentence; "" before that is known
  ///@}

  ///@{
  /// About the last successful execution.
  vtkGetMacro(FitSeconds, double);
  vtkGetMacro(Noise, double); // estimated, scanner units
  vtkGetMacro(NumberOfNonFiniteVoxels, vtkIdType);
  int GetNumberOfWarnings();
  std::string GetWarning(int index); // a sentence for the user
  /// "name=value" pairs separated by "; ": every setting as it was used, with what was chosen filled in.
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
  std::vector<vtkImageData*> GetInputImages();
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
  double HeldOutFraction = 0;
  bool KeepModelWhenAborted = false;
  int CurrentIteration = 0, TotalIterations = 0, NumberOfHeldOutSlices = 0, QualityState = QualityNotAsked;
  double CurrentLoss = 0, TrainingPSNR, HeldOutPSNR, ElapsedSeconds = 0, RemainingSeconds = 0;
  vtkIdType CurrentGaussians = 0, NumberOfNonFiniteVoxels = 0;
  double FitSeconds = 0, Noise = 0;
  std::string UsedSettings, UsedInstructionSet, UsedDevice, PredictionNote, DeviceNote;

private:
  vtkInnerGSReconstruct(const vtkInnerGSReconstruct&) = delete;
  void operator=(const vtkInnerGSReconstruct&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
