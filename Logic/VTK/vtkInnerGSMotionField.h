#ifndef vtkInnerGSMotionField_h
#define vtkInnerGSMotionField_h

#include "vtkInnerGSAlgorithm.h"

class vtkImageData;
class vtkInnerGSDynamicModel;
class vtkMatrix4x4;

/// How a dynamic scan moves (input: vtkInnerGSDynamicModel): a displacement field (output: vtkImageData of
/// three floats, mm in RAS, "Displacement"). What lies at voxel centre x at the time From lies at x + d(x) at
/// the time that the pipeline asks for, else Time; resampling the later volume through the field gives the
/// one at From. The grid: a reference grid, or the fitted region's (default). It is an error if the
/// Gaussians do not move.
class VTKINNERGS_EXPORT vtkInnerGSMotionField : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSMotionField* New();
  vtkTypeMacro(vtkInnerGSMotionField, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// s; used where the pipeline asks for no time. 0 by default.
  vtkSetMacro(Time, double);
  vtkGetMacro(Time, double);
  ///@{
  /// s. By default (UseMiddleFrame) the time of the frame in the middle.
  vtkSetMacro(From, double);
  vtkGetMacro(From, double);
  vtkSetMacro(UseMiddleFrame, bool);
  vtkGetMacro(UseMiddleFrame, bool);
  vtkBooleanMacro(UseMiddleFrame, bool);
  ///@}
  /// IJK→RAS, copied, and voxels along I, J, K. Null matrix: none.
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);

  /// The same as SetInputData.
  void SetDynamicModel(vtkInnerGSDynamicModel* model);
  vtkImageData* GetOutput();
  /// The matrix of the output image.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();

protected:
  vtkInnerGSMotionField();
  ~vtkInnerGSMotionField() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  double Time = 0, From = 0;
  bool UseMiddleFrame = true;

private:
  vtkInnerGSMotionField(const vtkInnerGSMotionField&) = delete;
  void operator=(const vtkInnerGSMotionField&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
