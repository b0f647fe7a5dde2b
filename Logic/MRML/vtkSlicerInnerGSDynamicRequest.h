#ifndef vtkSlicerInnerGSDynamicRequest_h
#define vtkSlicerInnerGSDynamicRequest_h

#include "vtkSlicerInnerGSModuleLogicExport.h"

#include <vtkObject.h>
#include <vtkSmartPointer.h> // member
#include <vtkWeakPointer.h>  // member

class vtkDoubleArray;
class vtkMRMLSequenceNode;

/// What vtkSlicerInnerGSLogic::StartDynamicReconstruction() is asked for.
class VTK_SLICER_INNERGS_MODULE_LOGIC_EXPORT vtkSlicerInnerGSDynamicRequest : public vtkObject {
public:
  static vtkSlicerInnerGSDynamicRequest* New();
  vtkTypeMacro(vtkSlicerInnerGSDynamicRequest, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The moving scan: a sequence of scalar volumes of one lattice, its index the time.
  void SetSeries(vtkMRMLSequenceNode* sequence);
  vtkMRMLSequenceNode* GetSeries();
  /// s from one frame to the next, where the index is no time; 0 (default): the index.
  vtkSetMacro(Interval, double);
  vtkGetMacro(Interval, double);

  /// What changes with time; Automatic (default): what foresees withheld frames better.
  enum Kinds { Automatic = -1, Motion, Intensity, Network };
  vtkSetClampMacro(Kind, int, Automatic, Network);
  vtkGetMacro(Kind, int);
  /// −1 (default): from the data.
  vtkSetMacro(NumberOfGaussians, vtkIdType);
  vtkGetMacro(NumberOfGaussians, vtkIdType);
  vtkSetMacro(Seed, vtkTypeUInt64);
  vtkGetMacro(Seed, vtkTypeUInt64);
  /// 0 (default): all cores.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);

  ///@{
  /// The frames to make: at these times (s; null, the default: none given), else so many per second (0, the
  /// default: at the series' own times).
  void SetTimes(vtkDoubleArray* times);
  vtkDoubleArray* GetTimes();
  vtkSetMacro(Rate, double);
  vtkGetMacro(Rate, double);
  ///@}
  /// Judge the quality by a second fit, on frames that it does not see, beside linear interpolation in time.
  /// On by default.
  vtkSetMacro(EvaluateQuality, bool);
  vtkGetMacro(EvaluateQuality, bool);
  vtkBooleanMacro(EvaluateQuality, bool);

protected:
  vtkSlicerInnerGSDynamicRequest();
  ~vtkSlicerInnerGSDynamicRequest() override;

  vtkWeakPointer<vtkMRMLSequenceNode> Series;
  vtkSmartPointer<vtkDoubleArray> Times;
  double Interval = 0, Rate = 0;
  int Kind = Automatic, NumberOfThreads = 0;
  vtkIdType NumberOfGaussians = -1;
  vtkTypeUInt64 Seed = 1;
  bool EvaluateQuality = true;

private:
  vtkSlicerInnerGSDynamicRequest(const vtkSlicerInnerGSDynamicRequest&) = delete;
  void operator=(const vtkSlicerInnerGSDynamicRequest&) = delete;
};

#endif
