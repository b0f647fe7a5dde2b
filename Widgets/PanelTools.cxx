#include "Widgets/PanelTools.h"

#include <QAbstractSpinBox>
#include <QComboBox>
#include <QEvent>
#include <QLabel>
#include <QScrollArea>
#include <QSlider>
#include <QTimer>

namespace innergs::ui {

namespace {

constexpr int kLayoutDelays[] = {50, 400}; // ms: the layout takes longer on a busy machine

/// Takes whatever width there is, and the height that its text then needs: no more, so that a panel of
/// them is not taller than it must be.
class WrappedLabel : public QLabel {
public:
  explicit WrappedLabel(QWidget* parent) : QLabel(parent) {
    setWordWrap(true);
    QSizePolicy policy(QSizePolicy::Ignored, QSizePolicy::Preferred);
    policy.setHeightForWidth(true);
    setSizePolicy(policy);
  }
  QSize sizeHint() const override { return minimumSizeHint(); }
  QSize minimumSizeHint() const override { return {0, fontMetrics().height()}; }
};

} // namespace

QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent) {
  auto* label = new WrappedLabel(parent);
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

void reveal(QWidget* widget) {
  for (const int delay : kLayoutDelays)
    QTimer::singleShot(delay, widget, [widget] {
      for (QWidget* parent = widget->parentWidget(); parent; parent = parent->parentWidget())
        if (auto* area = qobject_cast<QScrollArea*>(parent)) return area->ensureWidgetVisible(widget, 0, 0);
    });
}

} // namespace innergs::ui
