#pragma once
#include <QAbstractButton>
#include <QAbstractSpinBox>
#include <QComboBox>
#include <QDir>
#include <QLabel>
#include <QLineEdit>
#include <QPixmap>
#include <QStyle>
#include <QStyleOptionComboBox>
#include <QTest>
#include <QWidget>

/// Shows a window and gives it the keyboard focus, since there may be no window manager to do so.
inline bool showActive(QWidget& window) {
  window.show();
  if (!QTest::qWaitForWindowExposed(&window)) return false;
  window.activateWindow();
  return QTest::qWaitForWindowActive(&window);
}

/// The first visible widget whose text does not fit, or that extends beyond its parent; "" if there is none.
inline QString clippedWidget(const QWidget& root) {
  const auto name = [](const QWidget* widget, const QString& text) {
    return QString("%1 '%2': \"%3\"").arg(widget->metaObject()->className(), widget->objectName(), text);
  };
  for (const auto* widget : root.findChildren<QWidget*>()) {
    if (!widget->isVisible() || widget->isWindow()) continue;
    const QRect rect = widget->geometry();
    if (widget->parentWidget()->objectName() != "qt_scrollarea_viewport" &&
        !widget->parentWidget()->rect().contains(rect) && !rect.isEmpty())
      return name(widget, QString("sticks out of its parent"));
    if (const auto* label = qobject_cast<const QLabel*>(widget); label && !label->text().isEmpty()) {
      const bool fits = label->wordWrap() ? label->height() >= label->heightForWidth(label->width())
                                          : label->width() >= label->sizeHint().width();
      if (!fits) return name(label, label->text());
    }
    if (const auto* button = qobject_cast<const QAbstractButton*>(widget))
      if (button->width() < button->minimumSizeHint().width() ||
          button->height() < button->minimumSizeHint().height())
        return name(button, button->text());
    if ((qobject_cast<const QComboBox*>(widget) || qobject_cast<const QAbstractSpinBox*>(widget)) &&
        widget->height() < widget->minimumSizeHint().height())
      return name(widget, "too low");
    if (const auto* combo = qobject_cast<const QComboBox*>(widget)) {
      QStyleOptionComboBox option;
      option.initFrom(combo);
      const QRect field =
          combo->style()->subControlRect(QStyle::CC_ComboBox, &option, QStyle::SC_ComboBoxEditField, combo);
      if (combo->fontMetrics().horizontalAdvance(combo->currentText()) > field.width())
        return name(combo, combo->currentText());
    }
    if (const auto* spin = qobject_cast<const QAbstractSpinBox*>(widget)) {
      const auto* edit = spin->findChild<QLineEdit*>();
      if (edit && edit->fontMetrics().horizontalAdvance(edit->text()) > edit->width())
        return name(spin, edit->text());
    }
  }
  return {};
}

/// Carries out pending layouts, and those that they trigger.
inline void layOut() {
  constexpr int levels = 40; // nesting levels of widgets
  for (int n = 0; n < levels; ++n)
    QCoreApplication::sendPostedEvents(nullptr, QEvent::LayoutRequest);
}

/// Saves a picture to look at, if the environment variable INNERGS_SCREENSHOTS names a folder.
inline void snapshot(QWidget& widget, const QString& name) {
  const QString folder = qEnvironmentVariable("INNERGS_SCREENSHOTS");
  if (folder.isEmpty()) return;
  layOut();
  widget.grab().save(QDir(folder).filePath(name + ".png"));
}
