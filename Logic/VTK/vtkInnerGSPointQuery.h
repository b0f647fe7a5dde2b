#ifndef vtkInnerGSPointQuery_h
#define vtkInnerGSPointQuery_h

#include "vtkInnerGSExport.h"
#include "vtkObject.h"

#include <string> // returned

class vtkFloatArray;
class vtkInnerGSModel;
class vtkPoints;

/// The model's value (scanner units) at points.
class VTKINNERGS_EXPORT vtkInnerGSPointQuery : public vtkObject {
public:
  static vtkInnerGSPointQuery* New();
  vtkTypeMacro(vtkInnerGSPointQuery, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void SetModel(vtkInnerGSModel* model);
  vtkInnerGSModel* GetModel();

  /// One value per RAS point (mm); where the model has none, vtkInnerGSModel::GetFillValue(). Returns false
  /// after an error (vtkErrorMacro, GetErrorMessage()); `values` is then empty.
  bool Evaluate(vtkPoints* points, vtkFloatArray* values);
  /// The value at one point; NaN after an error.
  double EvaluatePoint(double r, double a, double s);
  std::string GetErrorMessage();
  vtkGetMacro(ErrorCode, int); // 0 or one of vtkInnerGSAlgorithm::ErrorCodes

  /// 0 (default): all cores.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  /// "auto" (default: a GPU from eight million points on), "cpu" or "cuda:N".
  vtkSetMacro(Device, const std::string&);
  vtkGetMacro(Device, std::string);

protected:
  vtkInnerGSPointQuery();
  ~vtkInnerGSPointQuery() override;

  vtkInnerGSModel* Model = nullptr;
  int NumberOfThreads = 0;
  std::string Device = "auto";
  std::string ErrorMessage;
  int ErrorCode = 0;

private:
  vtkInnerGSPointQuery(const vtkInnerGSPointQuery&) = delete;
  void operator=(const vtkInnerGSPointQuery&) = delete;
};

#endif
