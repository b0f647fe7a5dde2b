#ifndef vtkInnerGSInterpolateTime_h
#define vtkInnerGSInterpolateTime_h

#include "vtkInnerGSAlgorithm.h"

class vtkInnerGSDynamicModel;
class vtkInnerGSModel;

/// The model of a dynamic scan (input: vtkInnerGSDynamicModel) at one time: a vtkInnerGSModel (output), for
/// planes, resampling and points behind it. The time is the one that the pipeline asks for
/// (UpdateTimeStep() of the last filter; TIME_STEPS and TIME_RANGE are those of the fitted frames), else
/// Time. Any time in between is as good as a frame's; before the first and after the last frame, the model is
/// as at that frame.
class VTKINNERGS_EXPORT vtkInnerGSInterpolateTime : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSInterpolateTime* New();
  vtkTypeMacro(vtkInnerGSInterpolateTime, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// s; used where the pipeline asks for no time. 0 by default.
  vtkSetMacro(Time, double);
  vtkGetMacro(Time, double);

  /// The same as SetInputData.
  void SetDynamicModel(vtkInnerGSDynamicModel* model);

  vtkInnerGSModel* GetOutput();
  /// The time (s) of the output.
  vtkGetMacro(OutputTime, double);

protected:
  vtkInnerGSInterpolateTime();
  ~vtkInnerGSInterpolateTime() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  double Time = 0, OutputTime = 0;

private:
  vtkInnerGSInterpolateTime(const vtkInnerGSInterpolateTime&) = delete;
  void operator=(const vtkInnerGSInterpolateTime&) = delete;
};

#endif
