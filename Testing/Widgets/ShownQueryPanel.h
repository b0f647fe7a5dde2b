#pragma once
#include "FittedModel.h"
#include "TestTools.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PlaneView.h"
#include "Widgets/QueryPanel.h"

#include <vtkMatrix4x4.h>

#include <QApplication>
#include <QMouseEvent>
#include <QtTest>

#include <array>

/// A panel with a model, on the screen.
struct Shown {
  FakeHost host;
  innergs::ui::QueryPanel panel;
  innergs::ui::PlaneView* view;

  explicit Shown(vtkInnerGSModel* model = nullptr, std::array<double, 2> window = {50, 350})
      : panel(&host), view(panel.findChild<innergs::ui::PlaneView*>("queryView")) {
    if (model) addModel(host, "ramp", model, window);
    panel.resize(420, 800);
    panel.show();
    if (!QTest::qWaitForWindowExposed(&panel)) qWarning("not exposed");
    if (model) panel.setModelId("ramp");
    layOut();
  }
  template <typename T>
  T* find(const char* name) {
    return panel.findChild<T*>(name);
  }
  QString message() {
    auto* line = find<innergs::ui::MessageLine>("queryMessage");
    return line->isVisible() ? line->text() : QString();
  }
};

inline void drag(QWidget* widget, QPoint from, QPoint to, Qt::MouseButton button = Qt::LeftButton,
                 Qt::KeyboardModifiers keys = Qt::NoModifier) {
  QTest::mousePress(widget, button, keys, from);
  for (int step = 1; step <= 4; ++step) {
    const QPoint at = from + (to - from) * step / 4;
    QMouseEvent move(QEvent::MouseMove, at, widget->mapToGlobal(at), Qt::NoButton, button, keys);
    QApplication::sendEvent(widget, &move);
  }
  QTest::mouseRelease(widget, button, keys, to);
}

inline innergs::Vec3 columnOf(vtkMatrix4x4* m, int c) {
  return {m->GetElement(0, c), m->GetElement(1, c), m->GetElement(2, c)};
}
