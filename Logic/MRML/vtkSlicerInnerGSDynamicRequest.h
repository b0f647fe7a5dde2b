#ifndef vtkSlicerInnerGSDynamicRequest_h
#define vtkSlicerInnerGSDynamicRequest_h

#include "vtkInnerGSSettingsMacro.h"
#include "vtkSlicerInnerGSModuleLogicExport.h"

#include <vtkObject.h>
#include <vtkSmartPointer.h> // member
#include <vtkWeakPointer.h>  // member

#include <memory> // member

class vtkDoubleArray;
class vtkMRMLSequenceNode;
#ifndef __VTK_WRAP__
namespace innergs {
struct Settings;
}
#endif

/// The request to vtkSlicerInnerGSLogic::StartDynamicReconstruction().
class VTK_SLICER_INNERGS_MODULE_LOGIC_EXPORT vtkSlicerInnerGSDynamicRequest : public vtkObject {
public:
  static vtkSlicerInnerGSDynamicRequest* New();
  vtkTypeMacro(vtkSlicerInnerGSDynamicRequest, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The dynamic scan: a sequence of scalar volumes of one grid, its index the time.
  void SetSeries(vtkMRMLSequenceNode* sequence);
  vtkMRMLSequenceNode* GetSeries();
  /// s from one frame to the next, if the index is not a time; 0 (default): from the index.
  vtkSetMacro(Interval, double);
  vtkGetMacro(Interval, double);

  ///@{
  /// When the slices of a frame were acquired (s after its time), for the setting sliceTiming: these times,
  /// one per slice along K, else those of a file (UTF-8; .json as BIDS has it, or text with the times), else
  /// the sequence's attributes InnerGS.SliceTiming ("0, 1, 0.5") and InnerGS.SliceEncodingDirection ("k", the
  /// default, "j-" ...), else the BIDS file beside the one that the sequence was read from. Null and "": not
  /// given, the default.
  void SetSliceTimes(vtkDoubleArray* times);
  vtkDoubleArray* GetSliceTimes();
  vtkSetMacro(SliceTimingFileName, const std::string&);
  vtkGetMacro(SliceTimingFileName, std::string);
  ///@}

  /// Settings, by their names in Docs/settings.md. Only those of dynamic scans, NumberOfGaussians, Seed,
  /// threads, instruction set and device have an effect. Kind: what changes with time; Automatic: whichever
  /// predicts held-out frames better.
  vtkInnerGSSettingsMacro();
  vtkInnerGSSettingMacro(NumberOfThreads, threads, int);
  enum Kinds { Motion, Intensity, Network };
  vtkInnerGSSettingMacro(Kind, kind, int);
#ifndef __VTK_WRAP__
  const innergs::Settings& GetSettings() const;
  void SetSettings(const innergs::Settings& settings);
#endif

  ///@{
  /// The frames to make: at these times (s; null, the default: none given), else this many per second (0, the
  /// default: at the series' own times).
  void SetTimes(vtkDoubleArray* times);
  vtkDoubleArray* GetTimes();
  vtkSetMacro(Rate, double);
  vtkGetMacro(Rate, double);
  ///@}
  /// Judges the quality by a second fit, on frames that it does not see, next to linear interpolation in
  /// time. On by default.
  vtkSetMacro(EvaluateQuality, bool);
  vtkGetMacro(EvaluateQuality, bool);
  vtkBooleanMacro(EvaluateQuality, bool);

  ///@{
  /// A model file to resume, of the same scan and settings: a job's GetRecoveryFile(), or what
  /// `innergs interpolate --save-model` wrote when it was interrupted; "" (default): none. UTF-8. The end of
  /// the fit removes a file in the recovery folder.
  vtkSetMacro(ResumeFileName, const std::string&);
  vtkGetMacro(ResumeFileName, std::string);
  /// Keeps the state of the fit in the recovery folder when Cancel() stops it, as when anything else does.
  /// Off by default.
  vtkSetMacro(KeepWhenCancelled, bool);
  vtkGetMacro(KeepWhenCancelled, bool);
  vtkBooleanMacro(KeepWhenCancelled, bool);
  ///@}

protected:
  vtkSlicerInnerGSDynamicRequest();
  ~vtkSlicerInnerGSDynamicRequest() override;

  vtkWeakPointer<vtkMRMLSequenceNode> Series;
  vtkSmartPointer<vtkDoubleArray> Times, SliceTimes;
  double Interval = 0, Rate = 0;
  bool EvaluateQuality = true, KeepWhenCancelled = false;
  std::string ResumeFileName, SliceTimingFileName;

private:
  void SetSettingNumber(const char* name, double number);
  double GetSettingNumber(const char* name);
  std::unique_ptr<innergs::Settings> Choices;

  vtkSlicerInnerGSDynamicRequest(const vtkSlicerInnerGSDynamicRequest&) = delete;
  void operator=(const vtkSlicerInnerGSDynamicRequest&) = delete;
};

#endif
