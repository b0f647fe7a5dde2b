#ifndef vtkSlicerInnerGSJob_h
#define vtkSlicerInnerGSJob_h

#include "vtkSlicerInnerGSModuleLogicExport.h"

#include <vtkObject.h>
#include <vtkSmartPointer.h> // members
#include <vtkWeakPointer.h>  // members

#include <memory> // member
#include <string> // returned
#include <vector> // member

class vtkImageData;
class vtkInnerGSDynamicModel;
class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLLabelMapVolumeNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLSequenceBrowserNode;
class vtkMRMLSequenceNode;
class vtkMRMLTableNode;
class vtkMatrix4x4;
#ifndef __VTK_WRAP__
namespace innergs {
struct Progress;
namespace mrml {
class JobDelivery;
}
} // namespace innergs
#endif

/// One reconstruction of vtkSlicerInnerGSLogic, or the learning of segments: its progress and its result. The
/// call data of the logic's events. Changes on the main thread only.
class VTK_SLICER_INNERGS_MODULE_LOGIC_EXPORT vtkSlicerInnerGSJob : public vtkObject {
public:
  static vtkSlicerInnerGSJob* New();
  vtkTypeMacro(vtkSlicerInnerGSJob, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum States { Queued, Running, Finished, Failed, Cancelled };
  vtkGetMacro(State, int);
  static const char* GetStateAsString(int state);
  /// Neither queued nor running.
  bool IsDone();

  /// Null when it was deleted.
  vtkMRMLInnerGSParameterNode* GetParameterNode();

  ///@{
  /// How far it is.
  std::string GetPhase(); // for people: "Preparing", "Fitting", ...
  /// The fit is complete and others judge its quality or estimate its uncertainty: a cancel ends only that.
  bool IsJudging();
  /// A model learns segments: the result is GetModelNode().
  vtkGetMacro(Learning, bool);
  double GetProgress();      // of the whole job, 0 to 1
  int GetCurrentIteration(); // of the second fit while the quality is judged
  int GetTotalIterations();
  double GetLoss();         // of the last iteration, normalised intensity units
  double GetTrainingPSNR(); // dB, fitted samples; NaN: unknown
  double GetHeldOutPSNR();  // dB on held-out slices, of a second fit that did not see them; NaN: unknown
  vtkIdType GetNumberOfGaussians();
  double GetElapsedSeconds();
  double GetRemainingSeconds(); // estimated, of the whole job
#ifndef __VTK_WRAP__
  /// All of the above.
  const innergs::Progress& GetProgressReport() const;
#endif
  vtkGetMacro(AgreementNote, std::string);  // how well several scans agree, in sentences; "": one scan
  vtkGetMacro(PredictionNote, std::string); // what was put between the slices, a sentence; "": nothing yet
  vtkGetMacro(ProfileNote, std::string);    // how thick the slices look, a sentence; "": unknown
  /// Where the fit runs, or ran in the end, and why; "" before that is known.
  vtkGetMacro(DeviceNote, std::string);
  /// One line for people.
  std::string GetDescription();
  ///@}

  /// The last preview (float, scanner units; geometry in the matrix alone); null before the first one.
  vtkImageData* GetPreviewImage();
  vtkMatrix4x4* GetPreviewIJKToRASMatrix();
  /// Of a dynamic scan, instead: the model so far, at any time; null before the first one and after the end.
  vtkInnerGSDynamicModel* GetPreviewModel();

  ///@{
  /// After the end. What went wrong, as one sentence that says what to do ("" unless Failed), and sentences
  /// that the user should read.
  vtkGetMacro(ErrorMessage, std::string);
  vtkGetMacro(ErrorCode, int); // one of vtkInnerGSAlgorithm::ErrorCodes, or 0
  int GetNumberOfWarnings();
  std::string GetWarning(int index);
  /// A model file to resume from (SetResumeFileName of a parameter node or request) if closing the scene or
  /// removing the parameter node stopped the fit, or a cancel with KeepWhenCancelled of a dynamic scan's
  /// request; else "".
  vtkGetMacro(RecoveryFile, std::string);
  /// "name=value; ...": every setting as it was used.
  vtkGetMacro(UsedSettings, std::string);
  vtkGetMacro(QualityState, int); // one of vtkInnerGSReconstruct::QualityStates
  vtkGetMacro(NumberOfHeldOutSlices, int);
  /// Share of held-out voxels inside their 90 % intervals (NaN: unknown), and a sentence on that ("": none).
  vtkGetMacro(UncertaintyCoverage, double);
  vtkGetMacro(UncertaintyNote, std::string);
  /// Null unless Finished, or when deleted since.
  vtkMRMLScalarVolumeNode* GetVolumeNode();
  vtkMRMLInnerGSModelNode* GetModelNode();
  vtkMRMLTableNode* GetTableNode();
  /// Where the slices of several scans were found to lie (vtkInnerGSReconstruct::GetSliceTable); null if they
  /// were not moved.
  vtkMRMLTableNode* GetSliceTableNode();
  vtkMRMLScalarVolumeNode* GetUncertaintyNode(); // standard deviations; null unless asked for and known
  vtkMRMLLabelMapVolumeNode* GetMeasuredNode();  // likewise: 1 where some slice measured the tissue, else 0
  /// Of a dynamic scan alone.
  vtkMRMLSequenceNode* GetSequenceNode();
  vtkMRMLSequenceBrowserNode* GetBrowserNode();
  ///@}

protected:
  vtkSlicerInnerGSJob();
  ~vtkSlicerInnerGSJob() override;
  friend class vtkSlicerInnerGSLogic;
#ifndef __VTK_WRAP__
  friend class innergs::mrml::JobDelivery;
#endif

  int State = Queued;
  bool Learning = false;
  std::unique_ptr<innergs::Progress> LastProgress;
  int ErrorCode = 0, QualityState = 0, NumberOfHeldOutSlices = 0;
  double UncertaintyCoverage;
  std::string UncertaintyNote, AgreementNote, PredictionNote, ProfileNote, DeviceNote, ErrorMessage,
      RecoveryFile, UsedSettings;
  std::vector<std::string> Warnings;
  vtkSmartPointer<vtkImageData> Preview;
  vtkSmartPointer<vtkMatrix4x4> PreviewIJKToRAS;
  vtkSmartPointer<vtkInnerGSDynamicModel> PreviewModel;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> ParameterNode;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> VolumeNode, UncertaintyNode;
  vtkWeakPointer<vtkMRMLLabelMapVolumeNode> MeasuredNode;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> ModelNode;
  vtkWeakPointer<vtkMRMLTableNode> TableNode, SliceTableNode;
  vtkWeakPointer<vtkMRMLSequenceNode> SequenceNode;
  vtkWeakPointer<vtkMRMLSequenceBrowserNode> BrowserNode;

private:
  vtkSlicerInnerGSJob(const vtkSlicerInnerGSJob&) = delete;
  void operator=(const vtkSlicerInnerGSJob&) = delete;
};

#endif
