#pragma once
#include <QWidget>

#include <functional>

class QFormLayout;
class QLabel;

namespace innergs::ui {

class Host;

/// Gives a widget or action the name by which scripts and tests find it, and a tooltip; returns it.
template <class Object>
Object* named(Object* object, const char* name, const QString& toolTip = {}) {
  object->setObjectName(QString::fromLatin1(name));
  if (!toolTip.isEmpty()) object->setToolTip(toolTip);
  return object;
}

/// A widget's layout, without margins of its own.
template <class Layout>
Layout* layoutWithoutMargins(QWidget* widget) {
  auto* layout = new Layout(widget);
  layout->setContentsMargins(0, 0, 0, 0);
  return layout;
}
/// A form whose fields grow, and move below labels that are too long.
QFormLayout* makeForm(QWidget* parent = nullptr);

/// A label with the tooltip of the field that it belongs to, and for its Alt key.
QLabel* labelFor(QWidget* field, const QString& text);
/// A label for sentences: wraps, is selectable by mouse and keyboard, plain text.
QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent);
/// The wheel changes a value only in the widget with the keyboard focus: scrolling a panel must not edit it.
void guardWheel(QWidget* parent);
/// Once the layout is done, scrolls the area around two widgets, if there is one, so that everything from the
/// first to the last is visible; if that is too much, from the first on.
void reveal(QWidget* first, QWidget* last);

///@{
/// Asks for a file in a dialog of this name, which opens in the host's folder. Once a file is chosen, its
/// folder becomes the host's, and `chosen` gets it.
using FileChosen = std::function<void(const QString& file)>;
void askForFile(QWidget* parent, Host* host, const char* name, const QString& title, const QString& filters,
                const FileChosen& chosen);
/// Likewise for a file to write (SaveDialog).
void askWhereToSave(QWidget* parent, Host* host, const char* name, const QString& title,
                    const QString& filters, const QString& proposed, const FileChosen& chosen);
///@}

} // namespace innergs::ui
