#ifndef vtkInnerGSDynamicModel_h
#define vtkInnerGSDynamicModel_h

#include "vtkDataObject.h"
#include "vtkInnerGSExport.h"
#include "vtkWrappingHints.h" // VTK_NEWINSTANCE

#include <memory> // std::shared_ptr
#include <string> // returned

namespace innergs {
struct DynamicField;
struct FeatureModel;
} // namespace innergs
class vtkInformation;
class vtkInformationVector;
class vtkInnerGSModel;

/// A fitted model of a dynamic scan: a continuous volume in space and time (s). At every time it is a
/// vtkInnerGSModel. What it holds never changes once set, so copies, shallow and deep alike, share it.
class VTKINNERGS_EXPORT vtkInnerGSDynamicModel : public vtkDataObject {
public:
  static vtkInnerGSDynamicModel* New();
  vtkTypeMacro(vtkInnerGSDynamicModel, vtkDataObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Removes all Gaussians.
  void Initialize() override;
  void ShallowCopy(vtkDataObject* source) override;
  void DeepCopy(vtkDataObject* source) override;
  /// Kibibytes.
  unsigned long GetActualMemorySize() override;

  bool IsEmpty();
  vtkIdType GetNumberOfGaussians();
  /// What changes with time: "motion" or "network" (Gaussians that move), "intensity" (that change in place);
  /// "" when empty.
  std::string GetKindName();
  /// One line for display.
  std::string GetDescription();

  ///@{
  /// The frames that it was fitted to, and their times in s. Before the first and after the last frame, the
  /// model is as at that frame.
  int GetNumberOfFrames();
  double GetFrameTime(int index); // NaN for an index out of range
  /// Returns false, changing nothing, if empty.
  bool GetTimeRange(double range[2]);
  ///@}

  ///@{
  /// The segments that its Gaussians' features decode to; 0: none. As in vtkInnerGSModel.
  int GetNumberOfSegments();
  std::string GetSegmentName(int index);
  ///@}

  /// The model at a time (s), with its segments then, for all filters that take a model. The caller deletes
  /// it (Python does so itself). Null when empty or when the time is not finite.
  VTK_NEWINSTANCE vtkInnerGSModel* NewModelAt(double time);

  /// The model in a pipeline's information, or null.
  static vtkInnerGSDynamicModel* GetData(vtkInformation* information);
  static vtkInnerGSDynamicModel* GetData(vtkInformationVector* informations, int index = 0);

#ifndef __VTK_WRAP__
  /// For C++: null when empty.
  std::shared_ptr<const innergs::DynamicField> GetField() const {
    return this->Field;
  }
  /// features: of the canonical Gaussians; null: none.
  void SetField(std::shared_ptr<const innergs::DynamicField> field,
                std::shared_ptr<const innergs::FeatureModel> features = nullptr);
  /// Null without features.
  std::shared_ptr<const innergs::FeatureModel> GetFeatures() const {
    return this->Features;
  }
#endif

protected:
  vtkInnerGSDynamicModel();
  ~vtkInnerGSDynamicModel() override;

private:
  vtkInnerGSDynamicModel(const vtkInnerGSDynamicModel&) = delete;
  void operator=(const vtkInnerGSDynamicModel&) = delete;

#ifndef __VTK_WRAP__
  void Share(vtkInnerGSDynamicModel* model);

  std::shared_ptr<const innergs::DynamicField> Field;
  std::shared_ptr<const innergs::FeatureModel> Features;
#endif
};

#endif
