#include "StorageTask.h"

#include "vtkInnerGSAlgorithm.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkCallbackCommand.h>
#include <vtkNew.h>

namespace innergs::mrml {

void runStorage(vtkMRMLInnerGSModelStorageNode* storage, const std::function<int()>& task, ErrorCode code,
                const std::string& otherwise) {
  vtkNew<vtkCallbackCommand> quiet;
  const unsigned long tag = storage->AddObserver(vtkCommand::ErrorEvent, quiet);
  const int done = task();
  storage->RemoveObserver(tag);
  if (done) return;
  if (const std::string message = storage->GetErrorMessage(); !message.empty())
    throw Error(vtkInnerGSAlgorithm::FromErrorNumber(storage->GetErrorCode()), message);
  throw Error(code, otherwise);
}

} // namespace innergs::mrml
