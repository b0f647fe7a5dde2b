#pragma once
#include "Core/Settings.h"

namespace innergs::vtk {

/// "name=value; ...": every setting that had a part in the result.
std::string settingsText(const Settings& settings, double heldOutFraction);

} // namespace innergs::vtk
