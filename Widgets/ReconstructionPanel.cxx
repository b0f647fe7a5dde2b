#include "Widgets/ReconstructionPanel.h"

#include "Core/Base/Error.h"
#include "Widgets/DeviceBox.h"
#include "Widgets/InputsTable.h"
#include "Widgets/MessageLine.h"
#include "Widgets/NumberSpin.h"
#include "Widgets/OutputBox.h"
#include "Widgets/PanelTools.h"
#include "Widgets/PinnedRow.h"
#include "Widgets/ProgressCard.h"
#include "Widgets/QualityCard.h"
#include "Widgets/RecoveryLine.h"
#include "Widgets/Section.h"
#include "Widgets/SettingsPanel.h"
#include "Widgets/SlicesLine.h"
#include "Widgets/TextFormat.h"

#include <QAbstractSpinBox>
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QLabel>
#include <QPushButton>
#include <QSet>
#include <QSpinBox>
#include <QVBoxLayout>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <algorithm>
#include <utility>

namespace innergs::ui {

namespace {

constexpr int kEstimateDelay = 250; // ms after the last change
constexpr int kAskedAgain = 2000;   // ms: memory that is missing may become free

QString estimateText(const Estimate& estimate) {
  const QString memory = estimate.memory <= 0 ? QString()
                         : estimate.available > 0
                             ? ReconstructionPanel::tr("%1 of memory (%2 free)")
                                   .arg(memorySize(estimate.memory), memorySize(estimate.available))
                             : ReconstructionPanel::tr("%1 of memory").arg(memorySize(estimate.memory));
  const QString time = estimate.seconds > 0 ? roughDuration(estimate.seconds) : QString();
  if (time.isEmpty() && memory.isEmpty()) return {};
  if (time.isEmpty()) return ReconstructionPanel::tr("Takes %1.").arg(memory);
  if (memory.isEmpty()) return ReconstructionPanel::tr("Takes %1.").arg(time);
  return ReconstructionPanel::tr("Takes %1, %2.").arg(time, memory);
}

} // namespace

ReconstructionPanel::ReconstructionPanel(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), choices_(new QWidget(this)) {
  setObjectName("ReconstructionPanel");
  auto* choices = layoutWithoutMargins<QVBoxLayout>(choices_);
  for (QWidget* part : {makeInputs(), makeOutput(), makeFit(), makeAdvanced()})
    choices->addWidget(part);

  progress_ = named(new ProgressCard(this), "progressCard");
  start_ = new PinnedRow(this);
  start_->setContent(makeStart());
  message_ = named(new MessageLine(this), "message");
  quality_ = named(new QualityCard(this), "qualityCard");
  slices_ = named(new SlicesLine(host, this), "slicesLine");
  auto* layout = new QVBoxLayout(this);
  for (QWidget* part : QWidgetList{choices_, start_, message_, progress_, quality_, slices_})
    layout->addWidget(part);
  layout->addStretch(1);

  estimateTimer_.setObjectName("estimateTimer");
  estimateTimer_.setInterval(kEstimateDelay);
  memoryTimer_.setInterval(kAskedAgain);
  for (QTimer* timer : {&estimateTimer_, &memoryTimer_}) {
    timer->setSingleShot(true);
    connect(timer, &QTimer::timeout, this, [this] {
      if (isVisible()) estimate(); // else when it is shown
    });
  }
  connect(button_, &QPushButton::clicked, this, &ReconstructionPanel::startOrCancel);
  connectHost();
  guardWheel(this);
  explain();
  setState(host->isRunning() ? State::Running : State::Idle);
  if (host->isRunning()) progress_->begin();
}

ReconstructionPanel::~ReconstructionPanel() = default;

void ReconstructionPanel::connectHost() {
  connect(host_, &Host::started, this, [this] {
    message_->clear();
    quality_->clear();
    progress_->begin();
    setState(State::Running);
    reveal(start_, progress_);
  });
  connect(host_, &Host::waiting, progress_, &ProgressCard::setWaiting);
  connect(host_, &Host::estimateChanged, &estimateTimer_, QOverload<>::of(&QTimer::start));
  connect(host_, &Host::progressed, progress_, &ProgressCard::setProgress);
  connect(host_, &Host::previewed, this, [this](vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
    if (progress_->setPreview(image, ijkToRAS)) reveal(start_, progress_); // it has grown
  });
  connect(host_, &Host::finished, this, [this](const Report& report) {
    progress_->finish();
    quality_->setReport(report);
    const bool resumed = !recovery_->file().isEmpty();
    recovery_->setFile({}); // the fit is complete
    setState(State::Idle);
    if (resumed) Q_EMIT requestChanged();
    reveal(quality_, slices_);
  });
  connect(host_, &Host::failed, this, [this](const QString& text) {
    progress_->hide();
    const QString next = recovery_->refresh() ? tr("There is no result yet.")
                                              : tr("There is no result. Change something and start again.");
    message_->say(sentence(text) + '\n' + next, true);
    setState(State::Idle);
    reveal(message_, message_);
  });
  connect(host_, &Host::ended, this, [this](const QString& why) {
    progress_->hide();
    recovery_->refresh();
    message_->say(why);
    setState(State::Idle);
    reveal(message_, message_);
  });
  connect(recovery_, &RecoveryLine::dropped, this, &ReconstructionPanel::edited);
  connect(recovery_, &RecoveryLine::chosen, this, [this](const RecoveredFit& fit) {
    Request request = this->request();
    request.settings = fit.settings;
    setRequest(request);
    edited();
  });
  connect(host_, &Host::cancelled, this, [this] {
    progress_->hide();
    message_->say(tr("Cancelled: there is no result."));
    setState(State::Idle);
  });
}

Request ReconstructionPanel::request() const {
  Request request;
  request.inputs = inputs_->inputs();
  if (mask_) request.maskId = mask_->currentId();
  if (region_) request.regionId = region_->currentId();
  output_->fill(request);
  request.settings = settings_->settings();
  request.settings.preset = static_cast<Preset>(preset_->currentData().toInt());
  if (fill_) request.settings.fill = fill_->value();
  request.settings.device = device_->device().toStdString();
  request.heldOutFraction = heldOutFraction_;
  request.resumeFile = recovery_->file();
  request.estimateUncertainty = uncertainty_->isChecked();
  request.evaluateQuality = evaluate_->isChecked();
  request.qualityGap = qualityGap_;
  return request;
}

void ReconstructionPanel::setRequest(const Request& request) {
  quiet_ = true;
  inputs_->setInputs(request.inputs);
  if (mask_) mask_->setCurrentId(request.maskId);
  if (fill_) fill_->setNumber(request.settings.fill);
  if (region_) region_->setCurrentId(request.regionId);
  output_->set(request);
  preset_->setCurrentIndex(std::max(0, preset_->findData(static_cast<int>(request.settings.preset))));
  device_->setDevice(QString::fromStdString(request.settings.device));
  settings_->setSettings(request.settings);
  heldOut_->setValue(100 * request.heldOutFraction);
  recovery_->setFile(request.resumeFile);
  uncertainty_->setChecked(request.estimateUncertainty);
  evaluate_->setChecked(request.evaluateQuality);
  gap_->setValue(std::max(1, request.qualityGap));
  heldOutFraction_ = request.heldOutFraction;
  qualityGap_ = request.qualityGap;
  quiet_ = false;
  explain();
  slices_->refresh();
  estimateTimer_.start();
}

void ReconstructionPanel::suggestInput(const QString& id) {
  if (state_ == State::Idle) inputs_->suggest(id);
}

void ReconstructionPanel::forgetResult() {
  quality_->clear();
  if (state_ != State::Idle) return;
  progress_->hide();
  message_->clear();
}

void ReconstructionPanel::explainMask() {
  if (!mask_) return;
  const QVector<InputChoice> inputs = inputs_->inputs();
  maskLabel_->setText(inputs.size() > 1 ? tr("Mas&k for all:") : tr("Mas&k:"));
  fill_->setEnabled(!mask_->currentId().isEmpty() ||
                    std::any_of(inputs.begin(), inputs.end(),
                                [](const InputChoice& input) { return !input.maskId.isEmpty(); }));
}

void ReconstructionPanel::edited() {
  if (quiet_) return;
  explain();
  estimateTimer_.start();
  Q_EMIT requestChanged();
}

void ReconstructionPanel::explain() {
  const Request request = this->request();
  const auto preset = static_cast<std::size_t>(request.settings.preset);
  presetLine_->setText(settingText(settingNamed("preset").words.at(preset).text));
  output_->explain(request.inputs);
  explainMask();
  gap_->setEnabled(request.evaluateQuality);
  if (settings_->settings().preset != request.settings.preset) {
    const bool before = std::exchange(quiet_, true);
    settings_->setSettings(request.settings); // what "automatic" leads to
    quiet_ = before;
  }
}

QString ReconstructionPanel::ownRefusal(const Request& request) const {
  if (request.inputs.isEmpty()) return tr("Choose a scan to reconstruct.");
  QSet<QString> seen;
  for (const InputChoice& input : request.inputs) {
    if (seen.contains(input.id))
      return tr("'%1' is in the list of scans twice: remove one.").arg(host_->volumeInfo(input.id).name);
    seen.insert(input.id);
    const VolumeInfo info = host_->volumeInfo(input.id);
    const int axis = std::clamp(input.sliceAxis < 0 ? info.sliceAxis : input.sliceAxis, 0, 2);
    if (info.dimensions[axis] == 1)
      return tr("'%1' has a single slice along %2: choose a scan of several slices, or another axis at "
                "'Slices along'.")
          .arg(info.name, QStringLiteral("IJK").mid(axis, 1));
  }
  if (request.grid == OutputGrid::Reference && request.referenceId.isEmpty())
    return tr("Choose a reference volume for the result's voxels, or another result grid.");
  try {
    checkSettings(request.settings);
  } catch (const Error& error) {
    return QString::fromStdString(error.what());
  }
  return {};
}

void ReconstructionPanel::estimate() {
  if (state_ != State::Idle) return;
  const Request request = this->request();
  QString refusal = ownRefusal(request);
  const bool nothingChosen = request.inputs.isEmpty();
  Estimate found;
  if (refusal.isEmpty()) {
    found = host_->estimate(request);
    refusal = found.refusal;
  }
  refusal_ = refusal;
  const auto kind = nothingChosen ? MessageLine::Kind::Information : MessageLine::Kind::Warning;
  refusalLine_->setMessage(kind, sentence(refusal));
  estimate_->setText(estimateText(found));
  estimate_->setVisible(!estimate_->text().isEmpty());
  device_->setReason(found.reason);
  if (!found.refusal.isEmpty() && found.available > 0 && found.memory > found.available)
    memoryTimer_.start();
  else
    memoryTimer_.stop();
  setState(state_);
}

void ReconstructionPanel::setState(State state) {
  const bool ended = state_ != State::Idle && state == State::Idle;
  const bool hadFocus = button_->hasFocus();
  state_ = state;
  choices_->setEnabled(state == State::Idle);
  switch (state) {
  case State::Idle:
    button_->setText(tr("&Reconstruct"));
    button_->setToolTip(refusal_.isEmpty() ? tr("Start the reconstruction.") : refusal_);
    break;
  case State::Running:
    button_->setText(tr("&Cancel"));
    button_->setToolTip(tr("Stop the reconstruction. What is complete is kept."));
    break;
  case State::Cancelling:
    button_->setText(tr("Cancelling…"));
    button_->setToolTip({});
    break;
  }
  button_->setEnabled(state == State::Running || (state == State::Idle && refusal_.isEmpty()));
  start_->setPinnedAtTop(state != State::Idle);
  progress_->head()->setVisible(state != State::Idle);
  if (state != State::Idle) {
    estimate_->hide();
    refusalLine_->hide();
    recovery_->hide();
  }
  if (state == State::Cancelling && hadFocus) {
    focusMoved_ = true;
    movedTo_ = QApplication::focusWidget();
  }
  if (ended && std::exchange(focusMoved_, false) && QApplication::focusWidget() == movedTo_)
    button_->setFocus();
  if (!ended) return;
  recovery_->refresh();
  estimateTimer_.start(0);
}

void ReconstructionPanel::startOrCancel() {
  if (state_ == State::Running) {
    setState(State::Cancelling);
    progress_->setCancelling();
    host_->cancel();
    return;
  }
  if (state_ != State::Idle) return;
  if (auto* spin = qobject_cast<QAbstractSpinBox*>(QApplication::focusWidget())) spin->interpretText();
  estimateTimer_.stop();
  estimate();
  if (!refusal_.isEmpty()) return;
  message_->clear();
  quality_->clear();
  progress_->hide();
  host_->start(request());
}

void ReconstructionPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (state_ != State::Idle) return;
  recovery_->refresh();
  estimateTimer_.start(0);
}

QWidget* ReconstructionPanel::makeInputs() {
  auto* group = new QGroupBox(tr("Scans"), this);
  auto* layout = new QVBoxLayout(group);
  inputs_ = named(new InputsTable(host_, group), "inputs");
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
      form = makeForm();
      layout->addLayout(form);
    }
    Selector* selector = named(host_->createSelector(role, group), name, tip);
    form->addRow(label, selector);
    connect(selector, &Selector::currentIdChanged, this, &ReconstructionPanel::edited);
    return selector;
  };
  mask_ = add(Host::Role::Mask, "maskSelector", tr("Mas&k:"),
              tr("Reconstruct only what is inside this segmentation, and up to one slice around it.\n"
                 "None: everything. A scan with its own mask uses that instead."));
  if (mask_) {
    maskLabel_ = qobject_cast<QLabel*>(form->labelForField(mask_));
    maskLabel_->setObjectName("maskLabel");
    const Setting& row = settingNamed("fill");
    fill_ = named(new NumberSpin(settingRange(row), group), "fillValue", settingTip(row));
    form->addRow(settingText(row.label) + ":", fill_);
    connect(fill_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, &ReconstructionPanel::edited);
  }
  region_ = add(Host::Role::Region, "regionSelector", tr("R&egion:"),
                tr("Reconstruct only what is inside this box. None: everything."));
  return group;
}

QWidget* ReconstructionPanel::makeOutput() {
  auto* group = new QGroupBox(tr("Result"), this);
  auto* layout = new QVBoxLayout(group);
  output_ = named(new OutputBox(host_, group), "output");
  layout->addWidget(output_);
  connect(output_, &OutputBox::changed, this, &ReconstructionPanel::edited);
  return group;
}

QWidget* ReconstructionPanel::makeFit() {
  auto* group = new QGroupBox(tr("Quality and time"), this);
  auto* form = makeForm(group);
  preset_ = named(new QComboBox(group), "preset", tr("More work takes longer and fits the scans better."));
  for (const SettingWord& word : settingNamed("preset").words)
    preset_->addItem(settingText(word.label), preset_->count());
  preset_->setCurrentIndex(1);
  preset_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  presetLine_ = makeWrappedLabel("presetLine", group);
  device_ = named(new DeviceBox(group), "deviceBox");
  evaluate_ = named(new QCheckBox(tr("&Judge the quality (a second fit)"), group), "evaluateQuality",
                    tr("Fit the first scan again with slices left out, and compare the result with\n"
                       "interpolation on those slices. The result itself uses all slices."));
  evaluate_->setChecked(true);
  form->addRow(tr("&Preset:"), preset_);
  form->addRow(presetLine_);
  form->addRow(tr("&Device:"), device_);
  uncertainty_ =
      named(new QCheckBox(tr("Estimate the uncertaint&y (further fits)"), group), "estimateUncertainty",
            tr("Add a volume of standard deviations: by how much the result may be off in each\n"
               "voxel. Takes a fit without every fifth slice, and two of simulated scans."));
  form->addRow(evaluate_);
  form->addRow(uncertainty_);
  connect(preset_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, &ReconstructionPanel::edited);
  connect(device_, &DeviceBox::changed, this, &ReconstructionPanel::edited);
  connect(evaluate_, &QCheckBox::toggled, this, &ReconstructionPanel::edited);
  connect(uncertainty_, &QCheckBox::toggled, this, &ReconstructionPanel::edited);
  return group;
}

QWidget* ReconstructionPanel::makeAdvanced() {
  auto* section = named(new Section(tr("Advanced &settings"), this), "advanced");
  auto* content = new QWidget(section);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(content);
  layout->addWidget(makeQualityOptions());
  settings_ = named(new SettingsPanel(content), "settings");
  layout->addWidget(settings_);
  section->setContent(content);
  connect(settings_, &SettingsPanel::settingsChanged, this, &ReconstructionPanel::edited);
  return section;
}

QWidget* ReconstructionPanel::makeQualityOptions() {
  auto* group = new QGroupBox(tr("How the quality is measured"), this);
  auto* form = makeForm(group);
  gap_ = named(new QSpinBox(group), "qualityGap",
               tr("The second fit keeps every n-th slice of the first scan and is scored on the others;\n"
                  "automatic: every 2nd of thick slices, every 4th of thin ones."));
  gap_->setRange(1, 64); // 1: the usual one
  gap_->setSpecialValueText(tr("automatic"));
  heldOut_ =
      named(new QDoubleSpinBox(group), "heldOutFraction",
            tr("Share of each scan's slices held out from a second fit, to judge the quality on them\n"
               "(0 to 50 %). The result itself is fitted to all slices; it takes about twice the time."));
  heldOut_->setRange(0, 50);
  heldOut_->setDecimals(1);
  heldOut_->setSuffix(tr(" %"));
  heldOut_->setSpecialValueText(tr("none"));
  for (QAbstractSpinBox* spin : std::initializer_list<QAbstractSpinBox*>{gap_, heldOut_}) {
    spin->setKeyboardTracking(false);
    spin->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  }
  form->addRow(tr("Keep one slice in:"), gap_);
  form->addRow(tr("Hold out slices:"), heldOut_);
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
  estimate_->setToolTip(tr("Estimated time, and memory (GB) beyond that of the scans."));
  estimate_->hide();
  refusalLine_ = named(new MessageLine(content), "refusal");
  button_ = named(new QPushButton(content), "reconstruct");
  button_->setMinimumHeight(2 * fontMetrics().lineSpacing());
  auto* row = new QHBoxLayout;
  row->addWidget(progress_->head(), 1);
  row->addWidget(button_, 0);
  recovery_ = named(new RecoveryLine(host_, RecoveryLine::Scans::Static, content), "recoveryLine");
  auto* layout = new QVBoxLayout(content);
  const int gap = layout->spacing() / 2;
  layout->setContentsMargins(0, gap, 0, gap);
  layout->addWidget(recovery_);
  layout->addWidget(estimate_);
  layout->addWidget(refusalLine_);
  layout->addLayout(row);
  return content;
}

} // namespace innergs::ui
