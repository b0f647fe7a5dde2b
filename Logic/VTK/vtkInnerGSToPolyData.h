#ifndef vtkInnerGSToPolyData_h
#define vtkInnerGSToPolyData_h

#include "vtkInnerGSAlgorithm.h"

class vtkPolyData;

/// The model's Gaussians (input) as vtkPolyData (output) for 3D display; of a model fitted inside a mask,
/// those centred where it has values. A vertex at every centre (RAS mm), with point data
/// - "Intensity" (active scalars): the value in scanner units;
/// - "Ellipsoid" (active tensors, 9 components, symmetric): the eigenvectors are the axes in RAS, the
///   eigenvalues the semi-axes in mm at EllipsoidRadius standard deviations. vtkTensorGlyph with a sphere of
///   radius 1 and ExtractEigenvalues on (its default) draws the ellipsoids;
/// - "Scales" (3 components): standard deviations along the axes, mm; "Orientation" (4): the axes' rotation
///   as a quaternion w, x, y, z in RAS, for vtkGlyph3DMapper;
/// - "Weight": w for normalised and additive blending (> 0), the opacity α for alpha blending (0 to 1);
/// - "Disagreement" (normalised blending, optional): the model's measure of uncertainty. At the Gaussian's
///   centre, the weighted standard deviation of the values that all Gaussians reaching it assign to that
///   point, in scanner units. It is large at edges and where overlapping Gaussians (in super-resolution: of
///   independently fitted members) disagree. A relative measure, not a calibrated error bar.
class VTKINNERGS_EXPORT vtkInnerGSToPolyData : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSToPolyData* New();
  vtkTypeMacro(vtkInnerGSToPolyData, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Maximum number of Gaussians, picked evenly from the model's spatial order; 0 (default): all.
  vtkSetClampMacro(MaximumNumberOfGaussians, vtkIdType, 0, VTK_ID_MAX);
  vtkGetMacro(MaximumNumberOfGaussians, vtkIdType);
  /// Size of the ellipsoids in standard deviations; 1 by default.
  vtkSetMacro(EllipsoidRadius, double);
  vtkGetMacro(EllipsoidRadius, double);
  /// Whether to compute "Disagreement"; on by default.
  vtkSetMacro(ComputeDisagreement, bool);
  vtkGetMacro(ComputeDisagreement, bool);
  vtkBooleanMacro(ComputeDisagreement, bool);

  vtkPolyData* GetOutput();

protected:
  vtkInnerGSToPolyData();
  ~vtkInnerGSToPolyData() override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  vtkIdType MaximumNumberOfGaussians = 0;
  double EllipsoidRadius = 1;
  bool ComputeDisagreement = true;

private:
  vtkInnerGSToPolyData(const vtkInnerGSToPolyData&) = delete;
  void operator=(const vtkInnerGSToPolyData&) = delete;
};

#endif
