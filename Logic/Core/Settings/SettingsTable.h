#pragma once
#include "Core/Settings/Setting.h"

namespace innergs {

/// Every setting once, in listing order. Command line, report, notes, VTK filter, scene, panel, Python and
/// Docs/settings.md are generated from it: a new setting is a member of Settings and a row here.
const std::vector<Setting>& settingsTable();

/// Throws Error(InvalidArgument) for an unknown name; the message suggests the nearest one.
const Setting& settingNamed(const std::string& name);

/// Whether the fit of a dynamic scan uses it. No other fit uses those of the group Dynamic.
bool concernsDynamicScans(const Setting& row);

/// "Learning rates" etc., for the lists in panels, help and documentation.
const char* groupTitle(Setting::Group group);

/// What an unset value means: "l2; preset paper: l1", "chosen from the data".
std::string automaticText(const Setting& row);

/// "name=value; ...": every setting that affected a result.
std::string settingsText(const Settings& settings, double heldOutFraction);
/// The same for a dynamic scan.
std::string dynamicSettingsText(const Settings& settings);

/// The rows of the table in Docs/settings.md.
std::string settingsMarkdown();

} // namespace innergs
