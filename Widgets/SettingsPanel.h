#pragma once
#include "Core/Settings/SettingsTable.h"
#include "Widgets/NumberSpin.h"

#include <QWidget>

#include <functional>
#include <vector>

class QComboBox;
class QFormLayout;

namespace innergs::ui {

/// A text from the settings table in the user's language.
QString settingText(const char* text);
/// The range of a setting's field, and its tooltip.
NumberSpin::Range settingRange(const Setting& row);
QString settingTip(const Setting& row);

/// A field for every setting of a reconstruction except the basic ones, which have fields in the
/// reconstruction panel and are kept unchanged here. A field writes only the setting that the user edits, so
/// all others keep their exact values. "automatic": unset, chosen from the preset and the data.
class SettingsPanel : public QWidget {
  Q_OBJECT
public:
  explicit SettingsPanel(QWidget* parent = nullptr);
  /// For these settings alone; all others are kept unchanged.
  explicit SettingsPanel(const std::vector<const Setting*>& rows, QWidget* parent = nullptr);
  Settings settings() const;
  void setSettings(const Settings& settings);

public Q_SLOTS:
  /// All that have a field here.
  void restoreDefaults();

Q_SIGNALS:
  void settingsChanged();

private:
  struct Field {
    const Setting* row;
    QWidget* widget;
    std::function<void()> show; // shows the setting's current value
  };
  QFormLayout* makeGroup(const QString& title);
  QWidget* makeCheck(const Setting& row, std::function<void()>& show);
  QWidget* makeCombo(const Setting& row, std::function<void()>& show);
  QWidget* makeSpin(const Setting& row, std::function<void()>& show);
  void edit(const std::function<void()>& change);
  void showSettings();
  /// Shows what "automatic" means and disables settings without effect.
  void refresh();

  Settings settings_;
  std::vector<Field> fields_;
};

} // namespace innergs::ui
