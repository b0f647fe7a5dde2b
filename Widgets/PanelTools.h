#pragma once
#include <QWidget>

class QLabel;

namespace innergs::ui {

/// A label for sentences: wraps, is selectable by mouse and keyboard, plain text.
QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent);
/// The wheel changes a value only in the widget with the keyboard focus: scrolling a panel must not edit it.
void guardWheel(QWidget* parent);
/// Once the layout is done, scrolls the area around two widgets, if there is one, so that everything from the
/// first to the last is visible; if that is too much, from the first on.
void reveal(QWidget* first, QWidget* last);

} // namespace innergs::ui
