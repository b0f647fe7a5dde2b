#pragma once
#include <QFileDialog>

namespace innergs::ui {

/// Asks for a file to write. The file gets the (first) extension of the chosen filter: it changes with the
/// filter, and is added to a name that ends in none of the filters' extensions.
class SaveDialog : public QFileDialog {
  Q_OBJECT
public:
  /// filters: separated by ";;"; name: proposed, with or without an extension.
  SaveDialog(QWidget* parent, const QString& title, const QString& folder, const QString& filters,
             const QString& name);
  /// Returns the file with its extension. If that makes it the name of an existing file, which the dialog
  /// itself cannot have asked about, asks; "" if the file must stay.
  QString complete(const QString& file);

private:
  QString withoutEnd(const QString& file) const;
};

} // namespace innergs::ui
