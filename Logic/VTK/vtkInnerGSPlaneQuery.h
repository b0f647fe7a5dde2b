#ifndef vtkInnerGSPlaneQuery_h
#define vtkInnerGSPlaneQuery_h

#include "vtkInnerGSAlgorithm.h"

#include "vtkSmartPointer.h"

class vtkAbstractTransform;
class vtkImageData;
class vtkMatrix4x4;

/// Renders the model (input) on a plane as a 2D vtkImageData (output, float, scanner units), fast enough to
/// follow a drag. Keeps threads and buffers between executions. Port 1: the standard deviation on the plane,
/// if that of the model's volume is the second input.
class VTKINNERGS_EXPORT vtkInnerGSPlaneQuery : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSPlaneQuery* New();
  vtkTypeMacro(vtkInnerGSPlaneQuery, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// Plane coordinates (x right, y up in the plane, z along its normal) → RAS, copied. Any invertible matrix,
  /// e.g. a slice node's SliceToRAS (spacing in mm) or XYToRAS (with spacing 1, 1 and Centred off).
  void SetPlaneToRASMatrix(vtkMatrix4x4* planeToRAS);
  vtkMatrix4x4* GetPlaneToRASMatrix();
  /// Pixels; 256×256 by default.
  vtkSetVector2Macro(Dimensions, int);
  vtkGetVector2Macro(Dimensions, int);
  /// Distance of pixel centres in plane coordinates; 1, 1 by default.
  vtkSetVector2Macro(Spacing, double);
  vtkGetVector2Macro(Spacing, double);
  /// On (default): the plane's origin is the centre of the image. Off: it is the centre of pixel (0, 0).
  vtkSetMacro(Centred, bool);
  vtkGetMacro(Centred, bool);
  vtkBooleanMacro(Centred, bool);
  ///@}

  ///@{
  /// RAS → the RAS that the model was made in, for a model that has been moved; null (default): identity. A
  /// vtkLinearTransform maps the plane into the model, including shear; any other transform maps each pixel
  /// centre, like the points of vtkInnerGSPointQuery. No other thread may change it while the query runs.
  void SetTransformToModel(vtkAbstractTransform* rasToModel);
  vtkAbstractTransform* GetTransformToModel();
  ///@}

  ///@{
  /// The third output of vtkInnerGSReconstruct, in the model's own RAS, and its matrix (IJK → RAS, copied;
  /// null: from the image). Null image (default): the second output is empty.
  void SetStandardDeviationData(vtkImageData* deviation);
  void SetStandardDeviationIJKToRASMatrix(vtkMatrix4x4* ijkToRAS);
  /// On the grid of the first output: scalars "StandardDeviation" (float, scanner units) and point data
  /// "Measured" (unsigned char): 0 where no slice measured anything, and where the volume has no voxels.
  vtkImageData* GetOutputStandardDeviation();
  ///@}

  /// Device: the CPU by default, as it renders a plane in a few milliseconds; on other devices the model
  /// stays loaded.

  vtkImageData* GetOutput();
#ifndef __VTK_WRAP__
  /// Executes and hands over the output; null if it was stopped or failed.
  vtkSmartPointer<vtkImageData> Query();
#endif
  /// The matrix of the output image.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();
  /// Duration of the last execution in milliseconds.
  vtkGetMacro(QueryMilliseconds, double);

  vtkMTimeType GetMTime() override;

protected:
  vtkInnerGSPlaneQuery();
  ~vtkInnerGSPlaneQuery() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
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
