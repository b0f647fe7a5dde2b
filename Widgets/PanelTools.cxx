#include "Widgets/PanelTools.h"

#include <QAbstractSpinBox>
#include <QComboBox>
#include <QEvent>
#include <QLabel>

namespace innergs::ui {

QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent) {
  auto* label = new QLabel(parent);
  label->setObjectName(objectName);
  label->setTextFormat(Qt::PlainText);
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  QSizePolicy policy(QSizePolicy::Ignored, QSizePolicy::Minimum);
  policy.setHeightForWidth(true);
  label->setSizePolicy(policy);
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
}

} // namespace innergs::ui
