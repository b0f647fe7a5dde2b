#include "Core/Settings/Selection.h"

#include "Core/Settings/SettingsTable.h"

namespace innergs {

const char* selectionName(Selection selection) {
  return settingNamed("selection").words[static_cast<std::size_t>(selection)].name;
}

} // namespace innergs
