#include "Core/Settings/Selection.h"

namespace innergs {

const char* selectionName(Selection selection) {
  switch (selection) {
  case Selection::Exact:
    return "exact";
  case Selection::Method1:
    return "method1";
  case Selection::Method2:
    return "method2";
  }
  return "";
}

std::optional<Selection> selectionNamed(const std::string& name) {
  for (const Selection selection : {Selection::Exact, Selection::Method1, Selection::Method2})
    if (name == selectionName(selection)) return selection;
  return {};
}

} // namespace innergs
