#pragma once
#include "Widgets/App/AppHost.h"

#include <QObject>

#include <functional>

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
  /// Says that a tracked sweep needs its calibration, and offers to choose it.
  void askCalibration(const QString& id);
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
  /// A sentence with a button that lets the user choose a file.
  void offerFile(const QString& name, const QString& sentence, const QString& title, const QString& filter,
                 const std::function<void(const QString&)>& chosen);

  AppHost* host_;
  QWidget* window_; // above every dialog
};

} // namespace innergs::app
