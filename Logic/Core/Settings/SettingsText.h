#pragma once
#include "Core/Settings/Settings.h"

namespace innergs {

/// "name=value; ...": every setting that had a part in a result.
std::string settingsText(const Settings& settings, double heldOutFraction);

} // namespace innergs
