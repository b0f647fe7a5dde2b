#pragma once
#include "Core/Settings/SettingsTable.h"
#include "Widgets/NumberSpin.h"

#include <QWidget>

#include <functional>
#include <vector>

class QComboBox;
class QFormLayout;

namespace innergs::ui {

/// A text of the settings' table in the user's language.
QString settingText(const char* text);
/// What the field of a setting may hold, and its tooltip.
NumberSpin::Range settingRange(const Setting& row);
QString settingTip(const Setting& row);

/// A field for every setting but the basic ones, which stand beside it in the reconstruction panel and are
/// kept as they were set. A field writes only the setting that the user edits, so that what was set comes
/// back as it was. "automatic": unset, chosen from the preset and the data.
class SettingsPanel : public QWidget {
  Q_OBJECT
public:
  explicit SettingsPanel(QWidget* parent = nullptr);
  Settings settings() const;
  void setSettings(const Settings& settings);

public Q_SLOTS:
  /// All but the basic ones.
  void restoreDefaults();

Q_SIGNALS:
  void settingsChanged();

private:
  struct Field {
    const Setting* row;
    QWidget* widget;
    std::function<void()> show; // the setting as it is
  };
  QFormLayout* makeGroup(const QString& title);
  QWidget* makeCheck(const Setting& row, std::function<void()>& show);
  QWidget* makeCombo(const Setting& row, std::function<void()>& show);
  QWidget* makeSpin(const Setting& row, std::function<void()>& show);
  void edit(const std::function<void()>& change);
  void showSettings();
  /// Says what "automatic" leads to and greys what has no effect.
  void refresh();

  Settings settings_;
  std::vector<Field> fields_;
};

} // namespace innergs::ui
