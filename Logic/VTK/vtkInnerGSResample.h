#ifndef vtkInnerGSResample_h
#define vtkInnerGSResample_h

#include "vtkInnerGSAlgorithm.h"

class vtkImageData;
class vtkMatrix4x4;

/// The model (input) on a grid: a vtkImageData (output, float, scanner units). The grid: a reference grid, or
/// the region that was fitted at OutputSpacing, or that region's own lattice (default).
class VTKINNERGS_EXPORT vtkInnerGSResample : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSResample* New();
  vtkTypeMacro(vtkInnerGSResample, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// mm; 0, 0, 0 (default): as the fit had it.
  vtkSetVector3Macro(OutputSpacing, double);
  vtkGetVector3Macro(OutputSpacing, double);
  /// Goes before OutputSpacing. IJK→RAS, copied, and voxels along I, J, K. Null matrix: none.
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);
  /// The same from an image; ijkToRAS null: from its origin, spacing and direction. Null image: none.
  void SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS = nullptr);
  bool HasReferenceGrid();
  ///@}

  /// Device: by default a GPU from eight million voxels on.

  vtkImageData* GetOutput();
  /// Of the output image.
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
