#pragma once
#include "Core/Base/Error.h"

namespace innergs {

/// What the app and the Slicer module say alike of requests that cannot run, all Error(InvalidArgument).
/// name: the volume's.
Error noInputError();
Error noMaskError(const std::string& name); // where other scans have one
Error noReferenceError();
Error outputIsInputError(const std::string& name);
Error outputIsMaskError(const std::string& name); // or the reference

} // namespace innergs
