#ifndef vtkInnerGSAlgorithm_h
#define vtkInnerGSAlgorithm_h

#include "vtkAlgorithm.h"
#include "vtkInnerGSExport.h"

#include <functional> // std::function
#include <memory>     // std::unique_ptr
#include <stop_token> // std::stop_token
#include <string>     // returned

class vtkDataObject;
class vtkInnerGSModel;
#ifndef __VTK_WRAP__
namespace innergs {
enum class ErrorCode;
}
#endif

/// Base class of the filters: errors, stopping, threads.
///
/// An error is reported once through vtkErrorMacro (ErrorEvent), as one sentence that says what is wrong and
/// what to do; GetErrorCode() is then non-zero and GetErrorMessage() returns the sentence. After an error or
/// a stop the outputs are empty, and the next Update() tries again.
class VTKINNERGS_EXPORT vtkInnerGSAlgorithm : public vtkAlgorithm {
public:
  vtkTypeMacro(vtkInnerGSAlgorithm, vtkAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// GetErrorCode() is 0 or one of these.
  enum ErrorCodes {
    InvalidArgumentError = 40001, // vtkErrorCode::UserError + 1 + innergs::ErrorCode
    FileNotFoundError,
    FileFormatError,
    UnsupportedImageError,
    GeometryError,
    NoDataError,
    MemoryError,
    IoError,
    CancelledError, // never reported: see GetAborted()
    InternalError
  };
  /// The error message of the last execution; "" after success.
  std::string GetErrorMessage();
  /// Whether the last execution was stopped by AbortExecute or Cancel().
  vtkGetMacro(Aborted, bool);

  /// Stops a running execution within 200 ms; may be called by an observer or from any other thread.
  /// AbortExecuteOn() does the same.
  void SetAbortExecute(vtkTypeBool abort) override;
  /// Likewise at any time: ends the running execution or, if there is none, the next one.
  void Cancel();

  /// Number of threads; 0 (default): all cores. Results never depend on it.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  /// "" (default): the best that the processor supports; "scalar", "AVX2" etc. for comparisons.
  vtkSetMacro(InstructionSet, const std::string&);
  vtkGetMacro(InstructionSet, std::string);

  /// Where to compute: "auto" (a GPU if that pays off), "cpu", "cuda" or "cuda:N". What does not fit on a
  /// device is computed on the CPU.
  vtkSetMacro(Device, const std::string&);
  vtkGetMacro(Device, std::string);

  /// Whether output images carry their geometry (RAS) in origin, spacing and direction. On by default. Off:
  /// origin 0 and spacing 1, as Slicer's volume nodes require of their image data.
  vtkSetMacro(GeometryInImage, bool);
  vtkGetMacro(GeometryInImage, bool);
  vtkBooleanMacro(GeometryInImage, bool);

  vtkMTimeType GetMTime() override;
  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputs,
                             vtkInformationVector* outputs) override;

#ifndef __VTK_WRAP__
  /// For callers that use exceptions: throws the last error as innergs::Error with its own code; does nothing
  /// if there was none.
  void RethrowError();
  static int ToErrorNumber(innergs::ErrorCode code); // one of ErrorCodes
  static innergs::ErrorCode FromErrorNumber(unsigned long number);
#endif

  ///@{
  /// As in VTK's own algorithms.
  void SetInputData(vtkDataObject* data);
  void SetInputData(int port, vtkDataObject* data);
  void AddInputData(vtkDataObject* data);
  void AddInputData(int port, vtkDataObject* data);
  ///@}

  ///@{
  /// For filters whose input is a model; the same as SetInputData.
  void SetModel(vtkInnerGSModel* model);
  vtkInnerGSModel* GetModel();
  ///@}

protected:
  vtkInnerGSAlgorithm();
  ~vtkInnerGSAlgorithm() override;
  /// A model, which may be missing (reported by our own message), and an image.
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;

#ifndef __VTK_WRAP__
  /// May throw innergs::Error, which is reported and empties the outputs.
  virtual void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs);
  virtual void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) = 0;

  std::stop_token GetStopToken() const;
  /// Runs the task; reports what it throws through vtkErrorMacro, keeps it and returns false.
  bool Guard(const std::function<void()>& task);
  /// The model on the first input port; throws Error if there is none or it is empty.
  vtkInnerGSModel* RequireModel(vtkInformationVector** inputs);
#endif

  bool Aborted = false;
  bool GeometryInImage = true;
  int NumberOfThreads = 0;
  std::string InstructionSet, Device = "auto";

private:
  vtkInnerGSAlgorithm(const vtkInnerGSAlgorithm&) = delete;
  void operator=(const vtkInnerGSAlgorithm&) = delete;

  struct Internals;
  std::unique_ptr<Internals> State;
};

#endif
