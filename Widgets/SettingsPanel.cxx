#include "Widgets/SettingsPanel.h"

#include "Core/Render/Render.h"
#include "Widgets/PanelTools.h"

#include <QCheckBox>
#include <QComboBox>
#include <QCoreApplication>
#include <QFormLayout>
#include <QGroupBox>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include <algorithm>

namespace innergs::ui {
namespace {

using Type = Setting::Type;

constexpr double kLeast = 1e-9, kMost = 1e9; // if the table leaves a side open or excludes the bound itself
constexpr double kExactWhole = 0x1p53;       // the largest whole number that a field holds exactly

/// The options of a choice: their labels, and their words for Setting::setText().
std::vector<std::pair<QString, std::string>> choicesOf(const Setting& row) {
  std::vector<std::pair<QString, std::string>> choices;
  if (row.type() == Type::Flag)
    return {{SettingsPanel::tr("yes"), "true"}, {SettingsPanel::tr("no"), "false"}};
  for (const SettingWord& word : row.words)
    choices.emplace_back(settingText(word.label), word.name);
  if (row.type() == Type::Text) {
    choices.emplace_back(settingText(row.automatic), "");
    for (const std::string& set : instructionSets())
      choices.emplace_back(QString::fromStdString(set), set);
  }
  return choices;
}

/// A setting's value for display; "" if it is unset.
QString shownIn(const Settings& settings, const Setting& row, const QLocale& locale) {
  const auto number = row.numberIn(settings);
  if (number == 0 && *row.zero) return settingText(row.zero);
  if (number && row.type() != Type::Flag && row.type() != Type::Choice) return locale.toString(*number);
  for (const auto& [label, text] : choicesOf(row))
    if (text == row.textIn(settings)) return label;
  return {};
}

std::vector<const Setting*> advancedSettings() {
  std::vector<const Setting*> rows;
  for (const Setting& row : settingsTable())
    if (row.group != Setting::Group::Basic && row.group != Setting::Group::Dynamic) rows.push_back(&row);
  return rows;
}

} // namespace

QString settingText(const char* text) {
  return *text ? QCoreApplication::translate("innergs", text) : QString();
}

NumberSpin::Range settingRange(const Setting& row) {
  const bool whole = row.type() != Type::Real;
  NumberSpin::Range range;
  range.lowest =
      row.type() == Type::Natural ? 0 : std::max(row.range.lowest, -kMost) + (row.range.open ? kLeast : 0);
  range.highest =
      std::min(row.range.highest, whole ? kExactWhole : kMost) - (row.range.openHigh ? kLeast : 0);
  range.integer = whole;
  range.automatic = row.member.optional;
  range.first = row.usual > 0 ? row.usual : row.numberIn(withPresetValues({})).value_or(0);
  return range;
}

QString settingTip(const Setting& row) {
  QString text = settingText(row.text).toHtmlEscaped();
  if (*row.automatic)
    text += " " + SettingsPanel::tr("Automatic: %1.").arg(settingText(row.automatic).toHtmlEscaped());
  return "<qt>" + text + "</qt>"; // enables wrapping
}

SettingsPanel::SettingsPanel(QWidget* parent) : SettingsPanel(advancedSettings(), parent) {}

SettingsPanel::SettingsPanel(const std::vector<const Setting*>& rows, QWidget* parent) : QWidget(parent) {
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  auto* hint = makeWrappedLabel("settingsHint", this);
  hint->setText(tr("'automatic' is chosen from the preset and the scans. Empty a field to return to it."));
  layout->addWidget(hint);
  QFormLayout* form = nullptr;
  auto group = Setting::Group::Basic;
  for (const Setting* shown : rows) {
    const Setting& row = *shown;
    if (row.group != group) form = makeGroup(settingText(groupTitle(group = row.group)));
    const QString unit = settingText(row.unit), label = settingText(row.label);
    Field field{&row, nullptr, {}};
    if (row.type() == Type::Flag && !row.member.optional)
      form->addRow(field.widget = makeCheck(row, field.show));
    else {
      const bool words = row.type() == Type::Flag || row.type() == Type::Choice || row.type() == Type::Text;
      field.widget = words ? makeCombo(row, field.show) : makeSpin(row, field.show);
      field.widget->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
      form->addRow((unit.isEmpty() ? label : tr("%1 (%2)").arg(label, unit)) + ":", field.widget);
      form->labelForField(field.widget)->setToolTip(settingTip(row));
    }
    named(field.widget, row.name, settingTip(row));
    fields_.push_back(field);
  }
  auto* defaults = named(new QPushButton(tr("Restore defaul&ts"), this), "restoreDefaults",
                         tr("Restore the defaults of all advanced settings. Preset and device stay."));
  layout->addWidget(defaults, 0, Qt::AlignLeft);
  guardWheel(this);
  showSettings();
  connect(defaults, &QPushButton::clicked, this, &SettingsPanel::restoreDefaults);
}

Settings SettingsPanel::settings() const {
  return settings_;
}

void SettingsPanel::setSettings(const Settings& settings) {
  settings_ = settings;
  showSettings();
  Q_EMIT settingsChanged();
}

void SettingsPanel::restoreDefaults() {
  Settings settings = settings_;
  for (const Field& field : fields_)
    field.row->setText(settings, "");
  setSettings(settings);
}

QFormLayout* SettingsPanel::makeGroup(const QString& title) {
  auto* group = new QGroupBox(title, this);
  layout()->addWidget(group);
  return makeForm(group);
}

void SettingsPanel::edit(const std::function<void()>& change) {
  change();
  refresh();
  Q_EMIT settingsChanged();
}

QWidget* SettingsPanel::makeCheck(const Setting& row, std::function<void()>& show) {
  auto* box = new QCheckBox(settingText(row.label));
  show = [=, this, &row] { box->setChecked(row.numberIn(settings_) != 0); };
  connect(box, &QCheckBox::toggled, this,
          [this, &row](bool on) { edit([&] { row.setNumber(settings_, on); }); });
  return box;
}

QWidget* SettingsPanel::makeCombo(const Setting& row, std::function<void()>& show) {
  auto* combo = new QComboBox;
  if (row.member.optional) combo->addItem(tr("automatic"), QString());
  for (const auto& [label, text] : choicesOf(row))
    combo->addItem(label, QString::fromStdString(text));
  combo->setSizeAdjustPolicy(QComboBox::AdjustToContents);
  show = [=, this, &row] {
    combo->setCurrentIndex(combo->findData(QString::fromStdString(row.textIn(settings_))));
  };
  connect(combo, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [=, this, &row] {
    edit([&] { row.setText(settings_, combo->currentData().toString().toStdString()); });
  });
  return combo;
}

QWidget* SettingsPanel::makeSpin(const Setting& row, std::function<void()>& show) {
  auto* spin = new NumberSpin(settingRange(row));
  if (!row.member.optional && *row.zero) spin->setSpecialValueText(settingText(row.zero));
  show = [=, this, &row] { spin->setNumber(row.numberIn(settings_)); };
  connect(spin, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this,
          [=, this, &row] { edit([&] { row.setNumber(settings_, spin->number()); }); });
  return spin;
}

void SettingsPanel::showSettings() {
  for (const Field& field : fields_) {
    const QSignalBlocker quiet(field.widget);
    field.show();
  }
  refresh();
}

void SettingsPanel::refresh() {
  for (const Field& field : fields_) {
    const Setting& row = *field.row;
    const bool effective = row.hasEffectIn(settings_);
    field.widget->setEnabled(effective);
    auto* form = static_cast<QFormLayout*>(field.widget->parentWidget()->layout());
    if (QWidget* label = form->labelForField(field.widget)) label->setEnabled(effective);
    if (!row.member.optional) continue;
    Settings without = settings_;
    row.setText(without, "");
    const QString chosen = shownIn(withPresetValues(without), row, locale());
    const QString text = chosen.isEmpty() ? tr("automatic") : tr("automatic (%1)").arg(chosen);
    if (auto* combo = qobject_cast<QComboBox*>(field.widget)) {
      combo->setItemText(0, text);
      combo->setMinimumWidth(combo->sizeHint().width()); // Qt keeps the minimum of the old text
    } else if (auto* spin = qobject_cast<NumberSpin*>(field.widget)) {
      spin->setSpecialValueText(text);
      spin->updateGeometry();
    }
  }
}

} // namespace innergs::ui
