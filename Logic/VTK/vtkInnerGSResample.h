#ifndef vtkInnerGSResample_h
#define vtkInnerGSResample_h

#include "vtkInnerGSAlgorithm.h"

class vtkImageData;
class vtkMatrix4x4;

/// Renders the model (input) on a grid as a vtkImageData (output, float, scanner units). The grid is a
/// reference grid, the fitted region at OutputSpacing, or that region's own grid (default).
class VTKINNERGS_EXPORT vtkInnerGSResample : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSResample* New();
  vtkTypeMacro(vtkInnerGSResample, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// mm; 0, 0, 0 (default): as in the fit.
  vtkSetVector3Macro(OutputSpacing, double);
  vtkGetVector3Macro(OutputSpacing, double);
  /// Overrides OutputSpacing. IJK→RAS, copied, and voxels along I, J, K. Null matrix: none.
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);
  /// Likewise from an image; ijkToRAS null: from its origin, spacing and direction. Null image: none.
  void SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS = nullptr);
  bool HasReferenceGrid();
  ///@}

  /// Device: by default, a GPU from eight million voxels on.

  vtkImageData* GetOutput();
  /// The matrix of the output image.
  vtkMatrix4x4* GetOutputIJKToRASMatrix();

protected:
  vtkInnerGSResample();
  ~vtkInnerGSResample() override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  double OutputSpacing[3] = {0, 0, 0};

private:
  vtkInnerGSResample(const vtkInnerGSResample&) = delete;
  void operator=(const vtkInnerGSResample&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
