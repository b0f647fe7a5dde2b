#pragma once
#include <QWidget>

class QLabel;

namespace innergs::ui {

/// A label for sentences: wraps, can be selected by mouse and keyboard, plain text.
QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent);
/// The wheel changes a value only in the widget that has the keyboard: scrolling a panel must not edit it.
void guardWheel(QWidget* parent);
/// Scrolls the area around two widgets, if there is one, so that all from the first to the last is seen once
/// it is laid out; where that is too much, from the first on.
void reveal(QWidget* first, QWidget* last);

} // namespace innergs::ui
