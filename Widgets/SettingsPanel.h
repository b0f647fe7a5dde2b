#pragma once
#include "Core/Settings/Settings.h"

#include <QWidget>

namespace innergs::ui {

class FieldForm;

/// Every setting of a fit but preset and device, which stand beside it in the reconstruction panel and are
/// kept as they were set. "automatic": chosen from the preset and the data.
class SettingsPanel : public QWidget {
  Q_OBJECT
public:
  explicit SettingsPanel(QWidget* parent = nullptr);
  Settings settings() const;
  void setSettings(const Settings& settings);

public Q_SLOTS:
  /// All but preset and device.
  void restoreDefaults();

Q_SIGNALS:
  void settingsChanged();

private:
  QWidget* makeGroup(const QString& title);
  void addModel();
  void addFit();
  void addSchedule();
  void addDensification();
  void addComputation();
  /// Says what "automatic" leads to and greys what has no effect.
  void refresh();

  FieldForm* form_;
};

} // namespace innergs::ui
