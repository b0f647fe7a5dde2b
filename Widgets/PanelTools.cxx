#include "Widgets/PanelTools.h"

#include "Widgets/HeightForWidth.h"

#include <QAbstractSpinBox>
#include <QComboBox>
#include <QEvent>
#include <QLabel>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>
#include <QTimer>

#include <algorithm>

namespace innergs::ui {

namespace {

constexpr int kLayoutDelays[] = {50, 400}; // ms: the layout takes longer on a busy machine

} // namespace

QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent) {
  auto* label = new HeightForWidth<QLabel>(parent);
  label->setWordWrap(true);
  label->setObjectName(objectName);
  label->setTextFormat(Qt::PlainText);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

namespace {

class WheelGuard : public QObject {
public:
  using QObject::QObject;
  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() != QEvent::Wheel || static_cast<QWidget*>(watched)->hasFocus()) return false;
    event->ignore();
    return true;
  }
};

} // namespace

void guardWheel(QWidget* parent) {
  auto* guard = new WheelGuard(parent);
  const auto add = [guard](QWidget* widget) {
    widget->setFocusPolicy(Qt::StrongFocus);
    widget->installEventFilter(guard);
  };
  for (auto* spin : parent->findChildren<QAbstractSpinBox*>())
    add(spin);
  for (auto* combo : parent->findChildren<QComboBox*>())
    add(combo);
  for (auto* slider : parent->findChildren<QSlider*>())
    add(slider);
}

void reveal(QWidget* first, QWidget* last) {
  for (const int delay : kLayoutDelays)
    QTimer::singleShot(delay, last, [first, last] {
      for (QWidget* parent = last->parentWidget(); parent; parent = parent->parentWidget())
        if (auto* area = qobject_cast<QScrollArea*>(parent)) {
          const int top = first->mapTo(area->widget(), QPoint(0, 0)).y();
          const int bottom = last->mapTo(area->widget(), QPoint(0, last->height())).y();
          QScrollBar* bar = area->verticalScrollBar();
          bar->setValue(std::min(std::max(bar->value(), bottom - area->viewport()->height()), top));
          return;
        }
    });
}

} // namespace innergs::ui
