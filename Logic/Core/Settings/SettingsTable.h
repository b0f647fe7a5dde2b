#pragma once
#include "Core/Settings/Setting.h"

namespace innergs {

/// Every setting once, in the order in which they are listed. Command line, report, notes, VTK filter, scene,
/// panel, Python and Docs/settings.md are made from it: a new setting is a member of Settings and a row here.
const std::vector<Setting>& settingsTable();

/// Throws Error(InvalidArgument) for an unknown name; the sentence says which is the nearest.
const Setting& settingNamed(const std::string& name);

/// "Learning rates", for the lists of panels, help and documentation.
const char* groupTitle(Setting::Group group);

/// What an unset value leads to: "l2; preset paper: l1", "chosen from the data".
std::string automaticText(const Setting& row);

/// "name=value; ...": every setting that had a part in a result.
std::string settingsText(const Settings& settings, double heldOutFraction);

/// The rows of the table in Docs/settings.md.
std::string settingsMarkdown();

} // namespace innergs
