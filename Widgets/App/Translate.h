#pragma once
#include <QCoreApplication>

namespace innergs::app {

/// The text in the user's language, for functions outside a QObject. n: a count, for plurals.
inline QString tr(const char* text, const char* remark = nullptr, int n = -1) {
  return QCoreApplication::translate("innergs::app", text, remark, n);
}

} // namespace innergs::app
