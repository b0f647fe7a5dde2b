#ifndef vtkInnerGSModel_h
#define vtkInnerGSModel_h

#include "vtkDataObject.h"
#include "vtkInnerGSExport.h"

#include <memory> // std::shared_ptr
#include <string> // returned

namespace innergs {
struct FeatureModel;
struct Model;
struct GaussianField;
} // namespace innergs
class vtkInformation;
class vtkInformationVector;
class vtkMatrix4x4;

/// A fitted model: a continuous volume made of 3D Gaussians. What it holds never changes once set, so copies,
/// shallow and deep alike, share it. Everything seen through VTK is in RAS millimetres; the innergs
/// structures behind GetCoreModel() are in LPS as ever.
class VTKINNERGS_EXPORT vtkInnerGSModel : public vtkDataObject {
public:
  static vtkInnerGSModel* New();
  vtkTypeMacro(vtkInnerGSModel, vtkDataObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Back to no Gaussians.
  void Initialize() override;
  void ShallowCopy(vtkDataObject* source) override;
  void DeepCopy(vtkDataObject* source) override;
  /// Kibibytes of Gaussians, optimiser state, residual grid and features.
  unsigned long GetActualMemorySize() override;

  bool IsEmpty();
  vtkIdType GetNumberOfGaussians();
  /// Iterations over the data that it was fitted for.
  int GetNumberOfIterations();
  /// "normalised", "additive", "alpha"; "" when empty.
  std::string GetBlendingName();
  /// One line for people: count, blending, size of GetBounds(), memory.
  std::string GetDescription();

  /// The axis-aligned RAS box (xmin, xmax, ymin, ...; mm, to voxel edges) of the region that was fitted, cut
  /// to the mask's box where there was one; of the Gaussians' centres when it is unlimited; the uninitialised
  /// bounds (1, -1, ...) when empty.
  void GetBounds(double bounds[6]);
  /// The lattice of that region, the default for resampling. False, and nothing changed, when there is none.
  bool GetDomain(vtkMatrix4x4* ijkToRAS, int dimensions[3]);
  /// Whether the model was fitted inside a mask, beyond which (and a margin of one slice) it has no values.
  bool IsMasked();
  /// Whether the model has a value at a point: it lies in the region that was fitted and not outside the
  /// mask.
  bool IsInside(double r, double a, double s);
  /// The value (scanner units) of every point where it has none: what was chosen when it was fitted inside a
  /// mask, else the background value.
  double GetFillValue();
  /// The value (scanner units) where no Gaussian reaches.
  double GetBackgroundValue();
  /// The least and the greatest value (scanner units) that it can have inside: those of the scans. False, and
  /// nothing changed, when they are not known.
  bool GetValueRange(double range[2]);

  ///@{
  /// The segments that the Gaussians' features decode to, once they were learned from a labelmap; 0: none
  /// yet.
  int GetNumberOfSegments();
  /// As the labelmap had it: "liver", "kidney_left". "" outside 0 to GetNumberOfSegments() − 1.
  std::string GetSegmentName(int index);
  ///@}

  /// The model in a pipeline's information, or null.
  static vtkInnerGSModel* GetData(vtkInformation* information);
  static vtkInnerGSModel* GetData(vtkInformationVector* informations, int index = 0);

#ifndef __VTK_WRAP__
  /// For C++: what Logic/Core and Logic/IO work with. Null when empty.
  std::shared_ptr<const innergs::Model> GetCoreModel() const {
    return this->CoreModel;
  }
  /// features: of this model's Gaussians; null: none.
  void SetCoreModel(std::shared_ptr<const innergs::Model> core,
                    std::shared_ptr<const innergs::FeatureModel> features = nullptr);
  /// Null without features.
  std::shared_ptr<const innergs::FeatureModel> GetFeatures() const {
    return this->Features;
  }
  /// Whether both hold the same, Gaussians and features.
  bool HasContentOf(vtkInnerGSModel* other) const {
    return other && this->CoreModel == other->CoreModel && this->Features == other->Features;
  }
  /// Shares ownership of the model; null when empty.
  std::shared_ptr<const innergs::GaussianField> GetField() const;
#endif

protected:
  vtkInnerGSModel();
  ~vtkInnerGSModel() override;

private:
  vtkInnerGSModel(const vtkInnerGSModel&) = delete;
  void operator=(const vtkInnerGSModel&) = delete;

#ifndef __VTK_WRAP__
  void Share(vtkInnerGSModel* model);

  std::shared_ptr<const innergs::Model> CoreModel;
  std::shared_ptr<const innergs::FeatureModel> Features;
#endif
};

#endif
