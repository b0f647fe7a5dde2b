#pragma once
#include <QTest>
#include <QWidget>

/// Shows a window with the keyboard on it; there may be no window manager that would give it one.
inline bool showActive(QWidget& window) {
  window.show();
  if (!QTest::qWaitForWindowExposed(&window)) return false;
  window.activateWindow();
  return QTest::qWaitForWindowActive(&window);
}
