#include "vtkInnerGSAlgorithm.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"

#include "vtkDataObject.h"
#include "vtkDemandDrivenPipeline.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTimeStamp.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <atomic>
#include <mutex>

struct vtkInnerGSAlgorithm::Internals {
  mutable std::mutex mutex;
  std::stop_source stop; // of the running execution, or of the next one
  std::atomic<bool> executing{false};
  std::string message;
  bool unfinished = false; // the last execution failed or was stopped
  vtkTimeStamp again;

  std::stop_source source() const {
    std::lock_guard lock(mutex);
    return stop;
  }
};

vtkInnerGSAlgorithm::vtkInnerGSAlgorithm() : State(std::make_unique<Internals>()) {
  this->SetNumberOfInputPorts(1);
  this->SetNumberOfOutputPorts(1);
}
vtkInnerGSAlgorithm::~vtkInnerGSAlgorithm() = default;

void vtkInnerGSAlgorithm::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "InstructionSet: " << (this->InstructionSet.empty() ? "best" : this->InstructionSet)
     << "\n";
  os << indent << "GeometryInImage: " << this->GeometryInImage << "\n";
  os << indent << "Aborted: " << this->Aborted << "\n";
  os << indent << "ErrorMessage: " << this->State->message << "\n";
}

int vtkInnerGSAlgorithm::FillInputPortInformation(int, vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkInnerGSModel");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

int vtkInnerGSAlgorithm::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkImageData");
  return 1;
}

std::string vtkInnerGSAlgorithm::GetErrorMessage() {
  return this->State->message;
}

// While it executes, VTK's flag stays unchanged until the end: it is a plain int, and this may be another
// thread.
void vtkInnerGSAlgorithm::SetAbortExecute(vtkTypeBool abort) {
  if (!this->State->executing) {
    this->Superclass::SetAbortExecute(abort);
  } else if (abort) {
    this->Cancel();
  }
}

void vtkInnerGSAlgorithm::Cancel() {
  this->State->source().request_stop();
}

std::stop_token vtkInnerGSAlgorithm::GetStopToken() const {
  return this->State->source().get_token();
}

// The executive treats every execution as completed; a later modification time makes it try again.
vtkMTimeType vtkInnerGSAlgorithm::GetMTime() {
  if (this->State->unfinished && !this->State->executing) {
    this->State->again.Modified();
    this->State->unfinished = false;
  }
  return std::max(this->Superclass::GetMTime(), this->State->again.GetMTime());
}

void vtkInnerGSAlgorithm::RethrowError() {
  if (this->State->message.empty()) return;
  throw innergs::Error(FromErrorNumber(this->GetErrorCode()), this->State->message);
}

int vtkInnerGSAlgorithm::ToErrorNumber(innergs::ErrorCode code) {
  return InvalidArgumentError + static_cast<int>(code);
}

innergs::ErrorCode vtkInnerGSAlgorithm::FromErrorNumber(unsigned long number) {
  return static_cast<innergs::ErrorCode>(number - InvalidArgumentError);
}

bool vtkInnerGSAlgorithm::Guard(const std::function<void()>& task) {
  innergs::Failure failure;
  try {
    task();
    return true;
  } catch (...) {
    failure = innergs::failureOf();
  }
  if (failure.code == innergs::ErrorCode::Cancelled) {
    this->Aborted = true;
    return false;
  }
  this->State->message = failure.sentence;
  this->SetErrorCode(static_cast<unsigned long>(ToErrorNumber(failure.code)));
  vtkErrorMacro(<< failure.sentence);
  return false;
}

void vtkInnerGSAlgorithm::RequestInformation(vtkInformationVector**, vtkInformationVector*) {}

vtkTypeBool vtkInnerGSAlgorithm::ProcessRequest(vtkInformation* request, vtkInformationVector** inputs,
                                                vtkInformationVector* outputs) {
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA_OBJECT())) {
    for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port) {
      const char* type = this->GetOutputPortInformation(port)->Get(vtkDataObject::DATA_TYPE_NAME());
      vtkInformation* output = outputs->GetInformationObject(port);
      vtkDataObject* made = nullptr; // VTK's own factory does not know our types
      if (std::string("vtkInnerGSModel") == type && !vtkInnerGSModel::GetData(output))
        made = vtkInnerGSModel::New();
      if (std::string("vtkInnerGSDynamicModel") == type && !vtkInnerGSDynamicModel::GetData(output))
        made = vtkInnerGSDynamicModel::New();
      if (!made) continue;
      output->Set(vtkDataObject::DATA_OBJECT(), made);
      made->Delete();
    }
    return 1;
  }
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_INFORMATION())) {
    for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
      if (std::string("vtkImageData") ==
          this->GetOutputPortInformation(port)->Get(vtkDataObject::DATA_TYPE_NAME())) {
        const int empty[6] = {0, -1, 0, -1, 0, -1};
        outputs->GetInformationObject(port)->Set(Pipeline::WHOLE_EXTENT(), empty, 6);
      }
    try {
      this->RequestInformation(inputs, outputs);
    } catch (const std::exception&) { // occurs again, and is reported, when data are requested
    }
    return 1;
  }
  if (request->Has(Pipeline::REQUEST_UPDATE_EXTENT())) {
    for (int port = 0; port < this->GetNumberOfInputPorts(); ++port)
      for (int i = 0; i < inputs[port]->GetNumberOfInformationObjects(); ++i) {
        vtkInformation* input = inputs[port]->GetInformationObject(i);
        if (input->Has(Pipeline::WHOLE_EXTENT()))
          input->Set(Pipeline::UPDATE_EXTENT(), input->Get(Pipeline::WHOLE_EXTENT()), 6);
      }
    return 1;
  }
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA())) {
    this->State->message.clear();
    this->SetErrorCode(0);
    this->Aborted = false;
    {
      std::lock_guard lock(this->State->mutex);
      this->State->executing = true;
    }
    if (this->GetAbortExecute()) this->Cancel(); // requested by an observer of StartEvent
    const bool done = this->Guard([&] { this->RequestData(inputs, outputs); });
    if (!done)
      for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
        outputs->GetInformationObject(port)->Get(vtkDataObject::DATA_OBJECT())->Initialize();
    {
      std::lock_guard lock(this->State->mutex);
      this->State->executing = false;
      this->State->stop = std::stop_source();
      this->State->unfinished = !done || this->Aborted;
    }
#if VTK_MAJOR_VERSION > 9 || (VTK_MAJOR_VERSION == 9 && VTK_MINOR_VERSION >= 3)
    this->Superclass::SetAbortExecute(0); // earlier executives do so at the start
#else
    this->Superclass::SetAbortExecute(this->Aborted); // keeps the executive from reporting full progress
#endif
    return 1;
  }
  return this->Superclass::ProcessRequest(request, inputs, outputs);
}

vtkInnerGSModel* vtkInnerGSAlgorithm::RequireModel(vtkInformationVector** inputs) {
  vtkInnerGSModel* model = vtkInnerGSModel::GetData(inputs[0]);
  if (!model || model->IsEmpty())
    throw innergs::Error(innergs::ErrorCode::NoData,
                         "There is no model, or it has no Gaussians: reconstruct or load one first.");
  return model;
}

void vtkInnerGSAlgorithm::SetModel(vtkInnerGSModel* model) {
  this->SetInputDataObject(0, model);
}

vtkInnerGSModel* vtkInnerGSAlgorithm::GetModel() {
  return this->GetNumberOfInputConnections(0) ? vtkInnerGSModel::SafeDownCast(this->GetInputDataObject(0, 0))
                                              : nullptr;
}

void vtkInnerGSAlgorithm::SetInputData(vtkDataObject* data) {
  this->SetInputData(0, data);
}

void vtkInnerGSAlgorithm::SetInputData(int port, vtkDataObject* data) {
  this->SetInputDataInternal(port, data);
}

void vtkInnerGSAlgorithm::AddInputData(vtkDataObject* data) {
  this->AddInputData(0, data);
}

void vtkInnerGSAlgorithm::AddInputData(int port, vtkDataObject* data) {
  this->AddInputDataInternal(port, data);
}
