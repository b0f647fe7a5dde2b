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
#include "Widgets/Section.h"
#include "Widgets/SettingsPanel.h"
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

QString presetText(Preset preset) {
  switch (preset) {
  case Preset::Fast:
    return ReconstructionPanel::tr("The least work, for a first look.");
  case Preset::Balanced:
    return ReconstructionPanel::tr("The usual choice: good quality without a long wait.");
  case Preset::Best:
    return ReconstructionPanel::tr("The most work: somewhat better, several times slower.");
  case Preset::Paper:
    return ReconstructionPanel::tr("The published method, to compare: slow, and poor between slices.");
  }
  return {};
}

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
  auto* choices = new QVBoxLayout(choices_);
  choices->setContentsMargins(0, 0, 0, 0);
  for (QWidget* part : {makeInputs(), makeOutput(), makeFit(), makeAdvanced()})
    choices->addWidget(part);

  progress_ = new ProgressCard(this);
  progress_->setObjectName("progressCard");
  start_ = new PinnedRow(this);
  start_->setContent(makeStart());
  message_ = new MessageLine(this);
  message_->setObjectName("message");
  quality_ = new QualityCard(this);
  quality_->setObjectName("qualityCard");
  auto* layout = new QVBoxLayout(this);
  for (QWidget* part : {choices_, static_cast<QWidget*>(start_), static_cast<QWidget*>(message_),
                        static_cast<QWidget*>(progress_), static_cast<QWidget*>(quality_)})
    layout->addWidget(part);
  layout->addStretch(1);

  estimateTimer_.setObjectName("estimateTimer");
  estimateTimer_.setSingleShot(true);
  estimateTimer_.setInterval(kEstimateDelay);
  connect(&estimateTimer_, &QTimer::timeout, this, [this] {
    if (isVisible()) estimate(); // else when it is shown
  });
  memoryTimer_.setSingleShot(true);
  memoryTimer_.setInterval(kAskedAgain);
  connect(&memoryTimer_, &QTimer::timeout, this, [this] {
    if (isVisible()) estimate();
  });
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
  connect(host_, &Host::waiting, this, [this] { progress_->setWaiting(); });
  connect(host_, &Host::estimateChanged, this, [this] { estimateTimer_.start(); });
  connect(host_, &Host::progressed, this,
          [this](const Progress& progress) { progress_->setProgress(progress); });
  connect(host_, &Host::previewed, this, [this](vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
    if (progress_->setPreview(image, ijkToRAS)) reveal(start_, progress_); // it has grown
  });
  connect(host_, &Host::finished, this, [this](const Report& report) {
    progress_->finish();
    quality_->setReport(report);
    setState(State::Idle);
    reveal(quality_, quality_);
  });
  connect(host_, &Host::failed, this, [this](const QString& text) {
    progress_->hide();
    message_->setMessage(MessageLine::Kind::Error,
                         sentence(text) + '\n' + tr("No result was made. Start again after a change."));
    setState(State::Idle);
    reveal(message_, message_);
  });
  connect(host_, &Host::cancelled, this, [this] {
    progress_->hide();
    message_->setMessage(MessageLine::Kind::Information, tr("Cancelled: nothing was made."));
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
  request.evaluateQuality = evaluate_->isChecked();
  request.qualityGap = qualityGap_;
  return request;
}

void ReconstructionPanel::setRequest(const Request& request) {
  quiet_ = true;
  inputs_->setInputs(request.inputs);
  if (mask_) mask_->setCurrentId(request.maskId);
  if (fill_) {
    fill_->setNumber(request.settings.fill);
    enableFill();
  }
  if (region_) region_->setCurrentId(request.regionId);
  output_->set(request);
  preset_->setCurrentIndex(std::max(0, preset_->findData(static_cast<int>(request.settings.preset))));
  device_->setDevice(QString::fromStdString(request.settings.device));
  settings_->setSettings(request.settings);
  heldOut_->setValue(100 * request.heldOutFraction);
  evaluate_->setChecked(request.evaluateQuality);
  gap_->setValue(std::max(1, request.qualityGap));
  heldOutFraction_ = request.heldOutFraction;
  qualityGap_ = request.qualityGap;
  quiet_ = false;
  explain();
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

void ReconstructionPanel::enableFill() {
  fill_->setEnabled(!mask_->currentId().isEmpty());
}

void ReconstructionPanel::edited() {
  if (quiet_) return;
  explain();
  estimateTimer_.start();
  Q_EMIT requestChanged();
}

void ReconstructionPanel::explain() {
  const Request request = this->request();
  presetLine_->setText(presetText(request.settings.preset));
  output_->explain(request.inputs);
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
      return tr("\"%1\" is in the list of scans twice: remove one.").arg(host_->volumeInfo(input.id).name);
    seen.insert(input.id);
    const VolumeInfo info = host_->volumeInfo(input.id);
    const int axis = std::clamp(input.sliceAxis < 0 ? info.sliceAxis : input.sliceAxis, 0, 2);
    if (info.dimensions[axis] == 1)
      return tr("\"%1\" has a single slice along %2: choose a scan of several slices, or another axis at "
                "\"Slices along\".")
          .arg(info.name, QStringLiteral("IJK").mid(axis, 1));
  }
  if (request.grid == OutputGrid::Reference && request.referenceId.isEmpty())
    return tr("Choose the reference volume whose voxels the result gets, or another result grid.");
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
    button_->setToolTip(refusal_.isEmpty() ? tr("Starts the reconstruction.") : refusal_);
    break;
  case State::Running:
    button_->setText(tr("&Cancel"));
    button_->setToolTip(tr("Stops the reconstruction within a moment. What is complete is kept."));
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
  }
  if (state == State::Cancelling && hadFocus) {
    focusMoved_ = true;
    movedTo_ = QApplication::focusWidget();
  }
  if (ended && std::exchange(focusMoved_, false) && QApplication::focusWidget() == movedTo_)
    button_->setFocus();
  if (ended) estimateTimer_.start(0);
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
  if (state_ == State::Idle) estimateTimer_.start(0);
}

} // namespace innergs::ui
