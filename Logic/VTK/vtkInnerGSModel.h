#ifndef vtkInnerGSModel_h
#define vtkInnerGSModel_h

#include "vtkDataObject.h"
#include "vtkInnerGSExport.h"

#include <memory> // std::shared_ptr
#include <string> // returned

namespace innergs {
struct DynamicField;
struct FeatureModel;
struct Model;
struct GaussianField;
struct SegmentedModel;
} // namespace innergs
class vtkInformation;
class vtkInformationVector;
class vtkMatrix4x4;

/// A fitted model: a continuous volume made of 3D Gaussians. Its content never changes once set, so shallow
/// and deep copies share it. Everything seen through VTK is in RAS millimetres; the innergs structures behind
/// GetCoreModel() are in LPS.
class VTKINNERGS_EXPORT vtkInnerGSModel : public vtkDataObject {
public:
  static vtkInnerGSModel* New();
  vtkTypeMacro(vtkInnerGSModel, vtkDataObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Removes all Gaussians.
  void Initialize() override;
  void ShallowCopy(vtkDataObject* source) override;
  void DeepCopy(vtkDataObject* source) override;
  /// Kibibytes of Gaussians, optimiser state, residual grid and features.
  unsigned long GetActualMemorySize() override;

  bool IsEmpty();
  vtkIdType GetNumberOfGaussians();
  /// Number of iterations of its fit.
  int GetNumberOfIterations();
  /// "normalised", "additive" or "alpha"; "" if empty.
  std::string GetBlendingName();
  /// One line for display: count, blending, size of GetBounds(), memory.
  std::string GetDescription();

  /// The axis-aligned RAS box (xmin, xmax, ymin, ...; mm, to voxel edges) of the fitted region, cropped to
  /// the mask's box if there was one; if the region is unlimited, the box of the Gaussians' centres; if
  /// empty, the uninitialised bounds (1, -1, ...).
  void GetBounds(double bounds[6]);
  /// The grid of that region, the default for resampling. Returns false, changing nothing, if there is
  /// none.
  bool GetDomain(vtkMatrix4x4* ijkToRAS, int dimensions[3]);
  /// Whether the model was fitted inside a mask; beyond it (plus a margin of one slice) it has no values.
  bool IsMasked();
  /// Whether the model has a value at a point: inside the fitted region and not outside the mask.
  bool IsInside(double r, double a, double s);
  /// The value (scanner units) wherever the model has none: the one chosen for a fit inside a mask, else the
  /// background value.
  double GetFillValue();
  /// The value (scanner units) where no Gaussian reaches.
  double GetBackgroundValue();
  /// The range (scanner units) of its values inside: that of the scans. Returns false, changing nothing, if
  /// it is unknown.
  bool GetValueRange(double range[2]);

  ///@{
  /// The segments that the Gaussians' features decode to, once they were learned from a labelmap; 0: none
  /// yet. For a dynamic scan's model at a time, those of the scan.
  int GetNumberOfSegments();
  /// The name in the labelmap: "liver", "kidney_left". "" outside 0 to GetNumberOfSegments() − 1.
  std::string GetSegmentName(int index);
  ///@}

  /// The model in a pipeline's information, or null.
  static vtkInnerGSModel* GetData(vtkInformation* information);
  static vtkInnerGSModel* GetData(vtkInformationVector* informations, int index = 0);

#ifndef __VTK_WRAP__
  /// For C++: the model as used by Logic/Core and Logic/IO. Null if empty.
  std::shared_ptr<const innergs::Model> GetCoreModel() const {
    return this->CoreModel;
  }
  /// features: of this model's Gaussians; null: none. dynamic: the dynamic scan's model that this one shows at
  /// a time (s), and that the features belong to; null: it does not move.
  void SetCoreModel(std::shared_ptr<const innergs::Model> core,
                    std::shared_ptr<const innergs::FeatureModel> features = nullptr,
                    std::shared_ptr<const innergs::DynamicField> dynamic = nullptr, double time = 0);
  /// Null without features, and for a dynamic scan's model at a time, which cannot be saved with them.
  std::shared_ptr<const innergs::FeatureModel> GetFeatures() const {
    return this->Dynamic ? nullptr : this->Features;
  }
  /// What its segments are found in.
  innergs::SegmentedModel GetSegmented() const;
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
  std::shared_ptr<const innergs::DynamicField> Dynamic; // null: it does not move
  double Time = 0;                                      // s, of Dynamic
#endif
};

#endif
