#pragma once
#include "Core/Base/Error.h"

#include <functional>
#include <string>

class vtkMRMLInnerGSModelStorageNode;

namespace innergs::mrml {

/// Turns a storage node's failure into an Error, with its own code and sentence if it has one.
void runStorage(vtkMRMLInnerGSModelStorageNode* storage, const std::function<int()>& task, ErrorCode code,
                const std::string& otherwise);

} // namespace innergs::mrml
