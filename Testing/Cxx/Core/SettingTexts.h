#pragma once
#include "Core/Settings/SettingsTable.h"

namespace innergs::test {

/// A value that is not the setting's own default nor one of its neighbours'.
inline std::string otherText(const Setting& row) {
  using Type = Setting::Type;
  if (row.type() == Type::Choice) return row.words.back().name;
  if (row.type() == Type::Flag) return row.numberIn({}) == 1 ? "false" : "true";
  if (row.type() == Type::Text) return row.name == std::string("device") ? "cpu" : "scalar";
  if (row.type() == Type::Natural) return "18000000000000000001"; // more than a double can represent
  if (row.type() == Type::Integer) return row.name == std::string("ensembleSize") ? "2" : "7";
  return row.range.lowest == 1 ? "1.3333333333333333" : "0.33333333333333331"; // read as 1/3
}

} // namespace innergs::test
