#ifndef vtkSlicerInnerGSJob_h
#define vtkSlicerInnerGSJob_h

#include "vtkSlicerInnerGSModuleLogicExport.h"

#include <vtkObject.h>
#include <vtkSmartPointer.h> // members
#include <vtkWeakPointer.h>  // members

#include <string> // returned
#include <vector> // member

class vtkImageData;
class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLTableNode;
class vtkMatrix4x4;
#ifndef __VTK_WRAP__
namespace innergs::mrml {
class JobDelivery;
}
#endif

/// One reconstruction of vtkSlicerInnerGSLogic: how far it is and what it gave. The call data of the logic's
/// events. Changes on the main thread only.
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
  vtkGetMacro(Phase, std::string); // "Preparing", "Fitting", ...
  vtkGetMacro(Progress, double);   // of the whole job, 0 to 1
  vtkGetMacro(CurrentIteration, int);
  vtkGetMacro(TotalIterations, int);
  vtkGetMacro(Loss, double);         // of the last sweep, normalised intensity units
  vtkGetMacro(TrainingPSNR, double); // dB, fitted samples; NaN: unknown
  vtkGetMacro(HeldOutPSNR, double);  // dB; NaN when nothing was held out
  vtkGetMacro(NumberOfGaussians, vtkIdType);
  vtkGetMacro(ElapsedSeconds, double);
  vtkGetMacro(RemainingSeconds, double); // estimated
  /// Where the fit runs, or ran in the end, and why; "" before that is known.
  vtkGetMacro(DeviceNote, std::string);
  /// One line for people.
  std::string GetDescription();
  ///@}

  /// The last preview (float, scanner units; geometry in the matrix alone); null before the first one.
  vtkImageData* GetPreviewImage();
  vtkMatrix4x4* GetPreviewIJKToRASMatrix();

  ///@{
  /// After the end. What went wrong, as one sentence that says what to do ("" unless Failed), and sentences
  /// that the user should read.
  vtkGetMacro(ErrorMessage, std::string);
  int GetNumberOfWarnings();
  std::string GetWarning(int index);
  /// "name=value; ...": every setting as it was used.
  vtkGetMacro(UsedSettings, std::string);
  /// Null unless Finished, or when deleted since.
  vtkMRMLScalarVolumeNode* GetVolumeNode();
  vtkMRMLInnerGSModelNode* GetModelNode();
  vtkMRMLTableNode* GetTableNode();
  ///@}

protected:
  vtkSlicerInnerGSJob();
  ~vtkSlicerInnerGSJob() override;
  friend class vtkSlicerInnerGSLogic;
#ifndef __VTK_WRAP__
  friend class innergs::mrml::JobDelivery;
#endif

  int State = Queued;
  std::string Phase = "Waiting";
  double Progress = 0, Loss = 0, TrainingPSNR, HeldOutPSNR, ElapsedSeconds = 0, RemainingSeconds = 0;
  int CurrentIteration = 0, TotalIterations = 0;
  vtkIdType NumberOfGaussians = 0;
  std::string DeviceNote, ErrorMessage, UsedSettings;
  std::vector<std::string> Warnings;
  vtkSmartPointer<vtkImageData> Preview;
  vtkSmartPointer<vtkMatrix4x4> PreviewIJKToRAS;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> ParameterNode;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> VolumeNode;
  vtkWeakPointer<vtkMRMLInnerGSModelNode> ModelNode;
  vtkWeakPointer<vtkMRMLTableNode> TableNode;

private:
  vtkSlicerInnerGSJob(const vtkSlicerInnerGSJob&) = delete;
  void operator=(const vtkSlicerInnerGSJob&) = delete;
};

#endif
