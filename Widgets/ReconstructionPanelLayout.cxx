#include "Widgets/ReconstructionPanel.h"

#include "Widgets/DeviceBox.h"
#include "Widgets/InputsTable.h"
#include "Widgets/MessageLine.h"
#include "Widgets/NumberSpin.h"
#include "Widgets/OutputBox.h"
#include "Widgets/PanelTools.h"
#include "Widgets/ProgressCard.h"
#include "Widgets/Section.h"
#include "Widgets/SettingsPanel.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QLabel>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>

namespace innergs::ui {
namespace {

QFormLayout* makeForm(QWidget* parent) {
  auto* form = parent ? new QFormLayout(parent) : new QFormLayout;
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  form->setRowWrapPolicy(QFormLayout::WrapLongRows);
  return form;
}

} // namespace

QWidget* ReconstructionPanel::makeInputs() {
  auto* group = new QGroupBox(tr("Scans"), this);
  auto* layout = new QVBoxLayout(group);
  inputs_ = new InputsTable(host_, group);
  inputs_->setObjectName("inputs");
  layout->addWidget(inputs_);
  connect(inputs_, &InputsTable::changed, this, &ReconstructionPanel::edited);
  connect(inputs_, &InputsTable::refreshed, this, [this] {
    if (quiet_) return;
    explain();
    estimateTimer_.start();
  });
  QFormLayout* form = nullptr;
  const auto add = [&](Host::Role role, const char* name, const QString& label, const QString& tip) {
    if (!host_->offers(role)) return static_cast<Selector*>(nullptr);
    if (!form) {
      form = makeForm(nullptr);
      layout->addLayout(form);
    }
    Selector* selector = host_->createSelector(role, group);
    selector->setObjectName(name);
    selector->setToolTip(tip);
    form->addRow(label, selector);
    connect(selector, &Selector::currentIdChanged, this, &ReconstructionPanel::edited);
    return selector;
  };
  mask_ = add(Host::Role::Mask, "maskSelector", tr("Mas&k:"),
              tr("Only what is inside this segmentation is reconstructed, with up to one slice around it.\n"
                 "None: everything."));
  if (mask_) {
    fill_ = new NumberSpin({-1e9, 1e9}, group);
    fill_->setObjectName("fillValue");
    fill_->setToolTip(tr("The value of the result, and of everything shown of the model, outside the mask."));
    form->addRow(tr("Outside the mask:"), fill_);
    connect(fill_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, &ReconstructionPanel::edited);
    connect(mask_, &Selector::currentIdChanged, this, &ReconstructionPanel::enableFill);
    enableFill();
  }
  region_ = add(Host::Role::Region, "regionSelector", tr("R&egion:"),
                tr("Only what is inside this box is reconstructed. None: everything."));
  return group;
}

QWidget* ReconstructionPanel::makeOutput() {
  auto* group = new QGroupBox(tr("Result"), this);
  auto* layout = new QVBoxLayout(group);
  output_ = new OutputBox(host_, group);
  output_->setObjectName("output");
  layout->addWidget(output_);
  connect(output_, &OutputBox::changed, this, &ReconstructionPanel::edited);
  return group;
}

QWidget* ReconstructionPanel::makeFit() {
  auto* group = new QGroupBox(tr("Quality and time"), this);
  auto* form = makeForm(group);
  preset_ = new QComboBox(group);
  preset_->setObjectName("preset");
  preset_->addItem(tr("Fast"), static_cast<int>(Preset::Fast));
  preset_->addItem(tr("Balanced"), static_cast<int>(Preset::Balanced));
  preset_->addItem(tr("Best"), static_cast<int>(Preset::Best));
  preset_->addItem(tr("Paper"), static_cast<int>(Preset::Paper));
  preset_->setCurrentIndex(1);
  preset_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  preset_->setToolTip(tr("How much work to put in."));
  presetLine_ = makeWrappedLabel("presetLine", group);
  device_ = new DeviceBox(group);
  device_->setObjectName("deviceBox");
  evaluate_ = new QCheckBox(tr("&Measure the quality (a second fit)"), group);
  evaluate_->setObjectName("evaluateQuality");
  evaluate_->setChecked(true);
  evaluate_->setToolTip(tr("Fits the first scan again with slices left out, and compares the result with\n"
                           "interpolation on those slices. The result itself uses all slices."));
  form->addRow(tr("&Preset:"), preset_);
  form->addRow(presetLine_);
  form->addRow(tr("&Device:"), device_);
  form->addRow(evaluate_);
  connect(preset_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, &ReconstructionPanel::edited);
  connect(device_, &DeviceBox::changed, this, &ReconstructionPanel::edited);
  connect(evaluate_, &QCheckBox::toggled, this, &ReconstructionPanel::edited);
  return group;
}

QWidget* ReconstructionPanel::makeAdvanced() {
  auto* section = new Section(tr("Advanced &settings"), this);
  section->setObjectName("advanced");
  auto* content = new QWidget(section);
  auto* layout = new QVBoxLayout(content);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(makeQualityOptions());
  settings_ = new SettingsPanel(content);
  settings_->setObjectName("settings");
  layout->addWidget(settings_);
  section->setContent(content);
  connect(settings_, &SettingsPanel::settingsChanged, this, &ReconstructionPanel::edited);
  return section;
}

QWidget* ReconstructionPanel::makeQualityOptions() {
  auto* group = new QGroupBox(tr("How the quality is measured"), this);
  auto* form = makeForm(group);
  gap_ = new QSpinBox(group);
  gap_->setObjectName("qualityGap");
  gap_->setRange(1, 64); // 1: the usual one
  gap_->setSpecialValueText(tr("automatic"));
  gap_->setToolTip(tr("The second fit keeps every so many-th slice of the first scan and is scored on the\n"
                      "others; automatic: every 2nd of thick slices, every 4th of thin ones."));
  heldOut_ = new QDoubleSpinBox(group);
  heldOut_->setObjectName("heldOutFraction");
  heldOut_->setRange(0, 50);
  heldOut_->setDecimals(1);
  heldOut_->setSuffix(tr(" %"));
  heldOut_->setSpecialValueText(tr("none"));
  heldOut_->setToolTip(
      tr("Share of each scan's slices withheld from a second fit, to measure the quality on them\n"
         "(0 to 50 %). The result itself is fitted to all slices; it takes about twice the time."));
  for (QAbstractSpinBox* spin :
       {static_cast<QAbstractSpinBox*>(gap_), static_cast<QAbstractSpinBox*>(heldOut_)}) {
    spin->setKeyboardTracking(false);
    spin->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  }
  form->addRow(tr("Keep one slice in:"), gap_);
  form->addRow(tr("Withhold slices:"), heldOut_);
  connect(gap_, QOverload<int>::of(&QSpinBox::valueChanged), this, [this](int gap) {
    qualityGap_ = gap > 1 ? gap : 0;
    edited();
  });
  connect(heldOut_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this](double percent) {
    heldOutFraction_ = percent / 100;
    edited();
  });
  return group;
}

QWidget* ReconstructionPanel::makeStart() {
  auto* content = new QWidget(this);
  estimate_ = makeWrappedLabel("estimateText", content);
  estimate_->setToolTip(tr("Roughly, before the start: time, and memory (GB) beyond that of the scans."));
  estimate_->hide();
  refusalLine_ = new MessageLine(content);
  refusalLine_->setObjectName("refusal");
  button_ = new QPushButton(content);
  button_->setObjectName("reconstruct");
  button_->setMinimumHeight(2 * fontMetrics().lineSpacing());
  auto* row = new QHBoxLayout;
  row->addWidget(progress_->head(), 1);
  row->addWidget(button_, 0);
  auto* layout = new QVBoxLayout(content);
  const int gap = layout->spacing() / 2;
  layout->setContentsMargins(0, gap, 0, gap);
  layout->addWidget(estimate_);
  layout->addWidget(refusalLine_);
  layout->addLayout(row);
  return content;
}

} // namespace innergs::ui
