#ifndef vtkInnerGSPlaneQuery_h
#define vtkInnerGSPlaneQuery_h

#include "vtkInnerGSAlgorithm.h"

#include "vtkSmartPointer.h"

class vtkAbstractTransform;
class vtkImageData;
class vtkMatrix4x4;

/// The model (input) on a plane: a 2D vtkImageData (output, float, scanner units), fast enough to follow a
/// drag. Threads and buffers are kept between executions.
class VTKINNERGS_EXPORT vtkInnerGSPlaneQuery : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSPlaneQuery* New();
  vtkTypeMacro(vtkInnerGSPlaneQuery, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// Plane coordinates (x right, y up in the plane, z along its normal) → RAS, copied. Any invertible matrix,
  /// e.g. a slice node's SliceToRAS (then spacing in mm) or XYToRAS (then spacing 1, 1 and Centred off).
  void SetPlaneToRASMatrix(vtkMatrix4x4* planeToRAS);
  vtkMatrix4x4* GetPlaneToRASMatrix();
  /// Pixels; 256×256 by default.
  vtkSetVector2Macro(Dimensions, int);
  vtkGetVector2Macro(Dimensions, int);
  /// Between pixel centres, in plane coordinates; 1, 1 by default.
  vtkSetVector2Macro(Spacing, double);
  vtkGetVector2Macro(Spacing, double);
  /// On (default): the middle of the image is the plane's origin. Off: the centre of pixel (0, 0) is.
  vtkSetMacro(Centred, bool);
  vtkGetMacro(Centred, bool);
  vtkBooleanMacro(Centred, bool);
  ///@}

  ///@{
  /// RAS → the RAS that the model was made in, for a model that has been moved; null (default): the same. A
  /// vtkLinearTransform moves the plane into the model, with shear as well; through any other transform the
  /// pixel centres go one by one, as vtkInnerGSPointQuery's points. Another thread must not change it while
  /// the query runs.
  void SetTransformToModel(vtkAbstractTransform* rasToModel);
  vtkAbstractTransform* GetTransformToModel();
  ///@}

  /// Device: the CPU by default, as a plane takes it some milliseconds; on another one the model then stays.

  vtkImageData* GetOutput();
#ifndef __VTK_WRAP__
  /// Executes and gives the output away; null when it was stopped or failed.
  vtkSmartPointer<vtkImageData> Query();
#endif
  /// Of the output image.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();
  /// Milliseconds that the last execution took.
  vtkGetMacro(QueryMilliseconds, double);

  vtkMTimeType GetMTime() override;

protected:
  vtkInnerGSPlaneQuery();
  ~vtkInnerGSPlaneQuery() override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  int Dimensions[2] = {256, 256};
  double Spacing[2] = {1, 1};
  bool Centred = true;
  double QueryMilliseconds = 0;

private:
  vtkInnerGSPlaneQuery(const vtkInnerGSPlaneQuery&) = delete;
  void operator=(const vtkInnerGSPlaneQuery&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
