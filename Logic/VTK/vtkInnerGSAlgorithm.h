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

/// What the filters share: errors, stopping, threads.
///
/// An error is reported once through vtkErrorMacro (ErrorEvent) as one sentence that says what is wrong and
/// what to do; GetErrorCode() is then not zero and GetErrorMessage() the sentence. After an error or a stop
/// the outputs are empty, and the next Update() tries again.
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
  /// The sentence of the last execution's error; "" after success.
  std::string GetErrorMessage();
  /// Whether the last execution was stopped by AbortExecute or Cancel().
  vtkGetMacro(Aborted, bool);

  /// Stops a running execution within 200 ms; from an observer or any other thread. AbortExecuteOn() is the
  /// same.
  void SetAbortExecute(vtkTypeBool abort) override;
  /// The same at any time: ends the running execution, or the next one when none is running.
  void Cancel();

  /// Threads to work with; 0 (default): all cores. Results never depend on it.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  /// "" (default): the best that the processor has; "scalar", "AVX2" etc. to compare.
  vtkSetMacro(InstructionSet, const std::string&);
  vtkGetMacro(InstructionSet, std::string);

  /// Where to compute: "auto" (a GPU where that pays), "cpu", "cuda" or "cuda:N". What a device cannot hold
  /// is computed on the CPU.
  vtkSetMacro(Device, const std::string&);
  vtkGetMacro(Device, std::string);

  /// Whether output images carry their geometry (RAS) in origin, spacing and direction. On by default; off:
  /// origin 0, spacing 1, as image data of Slicer's volume nodes must be.
  vtkSetMacro(GeometryInImage, bool);
  vtkGetMacro(GeometryInImage, bool);
  vtkBooleanMacro(GeometryInImage, bool);

  vtkMTimeType GetMTime() override;
  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputs,
                             vtkInformationVector* outputs) override;

#ifndef __VTK_WRAP__
  /// The last error, for callers that go on with exceptions: throws innergs::Error with its own code; nothing
  /// when there was none.
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
  /// Of filters whose input is a model; the same as SetInputData.
  void SetModel(vtkInnerGSModel* model);
  vtkInnerGSModel* GetModel();
  ///@}

protected:
  vtkInnerGSAlgorithm();
  ~vtkInnerGSAlgorithm() override;
  /// A model, which may be missing (a sentence of our own says so), and an image.
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;

#ifndef __VTK_WRAP__
  /// May throw innergs::Error: reported, the outputs emptied.
  virtual void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs);
  virtual void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) = 0;

  std::stop_token GetStopToken() const;
  /// Runs the task; what it throws is reported through vtkErrorMacro and kept. False then.
  bool Guard(const std::function<void()>& task);
  /// The model on the first input port; throws Error when there is none or it is empty.
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
