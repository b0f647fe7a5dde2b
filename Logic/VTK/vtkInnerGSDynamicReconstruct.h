#ifndef vtkInnerGSDynamicReconstruct_h
#define vtkInnerGSDynamicReconstruct_h

#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSSettingsMacro.h"

class vtkDoubleArray;
class vtkInnerGSDynamicModel;
class vtkMatrix4x4;
#ifndef __VTK_WRAP__
namespace innergs {
struct Settings;
}
#endif

/// Fits a continuous volume in space and time to a dynamic scan. Input: its frames, scalar vtkImageData of
/// one grid (AddInputData once per frame, in the order of their times). Output: vtkInnerGSDynamicModel.
/// Inputs are never modified.
///
/// ProgressEvent: GetProgress(), GetProgressText() and the getters under "State of the fit", on the thread
/// that called Update().
class VTKINNERGS_EXPORT vtkInnerGSDynamicReconstruct : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSDynamicReconstruct* New();
  vtkTypeMacro(vtkInnerGSDynamicReconstruct, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Settings, by their names in Docs/settings.md. Only those of dynamic scans, NumberOfGaussians, Seed,
  /// threads, instruction set and device have an effect. Kind: what changes with time; Automatic: whichever
  /// predicts held-out frames better.
  vtkInnerGSSettingsMacro();
  enum Kinds { Motion, Intensity, Network };
  vtkInnerGSSettingMacro(Kind, kind, int);

  ///@{
  /// The time of the index-th frame, s; a frame without one is an error. SetTimeStep() sets them all: evenly
  /// spaced, the first at 0.
  void SetFrameTime(int index, double time);
  double GetFrameTime(int index); // NaN: not set
  void SetTimeStep(double interval, int numberOfFrames);
  ///@}
  ///@{
  /// When each slice of a frame was acquired, s after the frame's time, along an axis of the image (0, 1 or
  /// 2, the default). The setting sliceTiming uses this where Gaussians change their intensity. Null
  /// (default): all at once. Kept by reference.
  void SetSliceTimes(vtkDoubleArray* times);
  vtkDoubleArray* GetSliceTimes();
  vtkSetMacro(SliceAxis, int);
  vtkGetMacro(SliceAxis, int);
  ///@}
  /// IJK → RAS (mm) of all frames, copied; null (default): from the first image's origin, spacing and
  /// direction.
  void SetIJKToRASMatrix(vtkMatrix4x4* ijkToRAS);
  vtkMatrix4x4* GetIJKToRASMatrix();
  /// For messages.
  vtkSetMacro(SeriesName, const std::string&);
  vtkGetMacro(SeriesName, std::string);
  /// Disconnects all frames and forgets their times, their slice times and the matrix.
  void ClearInputs();

  /// When stopped while all frames are refined together, outputs the model fitted so far. Off by default.
  vtkSetMacro(KeepModelWhenAborted, bool);
  vtkGetMacro(KeepModelWhenAborted, bool);
  vtkBooleanMacro(KeepModelWhenAborted, bool);

  vtkInnerGSDynamicModel* GetOutput();

  ///@{
  /// State of the fit, for observers of ProgressEvent and after the end.
  std::string GetPhase();
  vtkGetMacro(ElapsedSeconds, double);
  vtkGetMacro(RemainingSeconds, double); // estimated
  vtkGetMacro(TrainingPSNR, double);     // dB, on the fitted frames; NaN: unknown
  vtkGetMacro(Choice, std::string);      // why the model is of its kind, a sentence; "" if the kind was given
  vtkGetMacro(UsedDevice, std::string);  // where the fit ended: "cpu", "cuda:N"
  vtkGetMacro(DeviceNote, std::string);  // where the fit runs and why, a sentence
  vtkGetMacro(Notes, std::string);       // sentences, one per line: what was requested or found, but not used
  ///@}

#ifndef __VTK_WRAP__
  innergs::Settings GetSettings() const;
  void SetSettings(const innergs::Settings& settings);
#endif

protected:
  vtkInnerGSDynamicReconstruct();
  ~vtkInnerGSDynamicReconstruct() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  bool KeepModelWhenAborted = false;
  int SliceAxis = 2;
  double ElapsedSeconds = 0, RemainingSeconds = 0, TrainingPSNR;
  std::string SeriesName = "The series", Choice, Notes, UsedDevice, DeviceNote;

private:
  vtkInnerGSDynamicReconstruct(const vtkInnerGSDynamicReconstruct&) = delete;
  void operator=(const vtkInnerGSDynamicReconstruct&) = delete;

  void SetSettingNumber(const char* name, double number);
  double GetSettingNumber(const char* name);
  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
