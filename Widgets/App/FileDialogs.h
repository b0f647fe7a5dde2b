#pragma once
#include "Widgets/App/AppHost.h"

#include <QObject>

namespace innergs::app {

/// The app's dialogs on files: which to open, where to save, whether unsaved items may be lost.
class FileDialogs : public QObject {
  Q_OBJECT
public:
  FileDialogs(AppHost* host, QWidget* window);

  void openFiles();
  void openFolder();
  /// Asks for the head if none is found.
  void openSample();
  /// Asks where; returns false if it was not written.
  bool saveAs(const QString& id);
  /// Asks if the item is not saved.
  void closeItem(const QString& id);
  /// Asks whether unsaved items may be lost.
  bool mayDiscard();
  void tell(const QString& sentence);

Q_SIGNALS:
  void saved(const QString& file);

private:
  AppHost* host_;
  QWidget* window_; // above every dialog
};

} // namespace innergs::app
