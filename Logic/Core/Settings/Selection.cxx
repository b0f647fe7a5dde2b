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

} // namespace innergs
