#include "Widgets/MotionPanel.h"

#include "Widgets/DeviceBox.h"
#include "Widgets/MessageLine.h"
#include "Widgets/NumberSpin.h"
#include "Widgets/PanelTools.h"
#include "Widgets/RecoveryLine.h"
#include "Widgets/Section.h"
#include "Widgets/SettingsPanel.h"
#include "Widgets/TextFormat.h"
#include "Widgets/ValueSlider.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDir>
#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QLocale>
#include <QProgressBar>
#include <QPushButton>
#include <QSignalBlocker>
#include <QStyle>
#include <QToolButton>

#include <cmath>
#include <utility>

namespace innergs::ui {

namespace {

constexpr int kPlayInterval = 40; // ms between two frames that are shown

QString seconds(double value) {
  return QLocale().toString(value, 'g', 6);
}

} // namespace

MotionPanel::MotionPanel(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), motion_(host->motion()) {
  qRegisterMetaType<innergs::ui::MotionReport>();
  build();
  connectAll();
  showSeries();
  showModel();
  ended();
}

void MotionPanel::build() {
  auto* all = layoutWithoutMargins<QVBoxLayout>(this);
  recovery_ = named(new RecoveryLine(host_, RecoveryLine::Scans::Dynamic, this), "motionRecoveryLine");
  all->addWidget(recovery_);
  all->addWidget(buildFit());
  all->addWidget(buildView());
  message_ = named(new MessageLine(this), "motionMessage");
  all->addWidget(message_);
  all->addStretch(1);
  guardWheel(this);
}

QWidget* MotionPanel::buildFit() {
  auto* box = new QGroupBox(tr("Reconstruct in space and time"), this);
  auto* layout = new QVBoxLayout(box);
  options_ = new QWidget(box);
  auto* form = layoutWithoutMargins<QFormLayout>(options_);
  series_ = named(host_->createSelector(Host::Role::Series, this), "motionSeries",
                  tr("A scan with several frames: a 4D file, or in 3D Slicer a sequence of volumes."));
  form->addRow(tr("Dynamic &scan"), series_);
  about_ = makeWrappedLabel(QStringLiteral("motionAbout"), this);
  form->addRow(QString(), about_);
  interval_ =
      named(new NumberSpin({1e-6, 1e6, false, true, 1}, this), "motionInterval",
            tr("Time from one frame to the next, if the scan does not state it, or states it wrongly."));
  interval_->setSuffix(tr(" s"));
  interval_->setSpecialValueText(tr("from the scan"));
  form->addRow(tr("&Time between frames"), interval_);
  kind_ = named(new QComboBox(this), "motionKind",
                tr("What changes with time. Unless you choose, the program tries both on a few frames."));
  kind_->addItem(tr("Chosen by held-out frames"), QString());
  for (const SettingWord& word : settingNamed("kind").words)
    kind_->addItem(settingText(word.label), QString::fromLatin1(word.name));
  kind_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  kind_->setMinimumContentsLength(12);
  form->addRow(tr("What &changes"), kind_);
  auto* timing = new QWidget(this);
  auto* file = layoutWithoutMargins<QHBoxLayout>(timing);
  sliceTimes_ = named(new QLineEdit(this), "motionSliceTimes",
                      tr("When the slices of a frame were acquired, where intensities change (fMRI): a BIDS "
                         "file (.json),\nor text with one time in s per slice."));
  sliceTimes_->setPlaceholderText(tr("from the scan"));
  sliceTimes_->setClearButtonEnabled(true);
  file->addWidget(sliceTimes_, 1);
  auto* choose = named(new QToolButton(this), "motionChooseSliceTimes", tr("Choose the file."));
  choose->setText(QStringLiteral("…"));
  choose->setAccessibleName(tr("Choose the file of slice times"));
  connect(choose, &QToolButton::clicked, this, &MotionPanel::chooseSliceTimes);
  file->addWidget(choose);
  timing->setFocusProxy(sliceTimes_);
  form->addRow(tr("Slice t&imes"), timing);
  rate_ = named(new NumberSpin({1e-3, 1e4, false, true, 1}, this), "motionRate",
                tr("Frames per second to save; the slider below shows any time."));
  rate_->setSuffix(tr(" per second"));
  rate_->setSpecialValueText(tr("the scan's own"));
  form->addRow(tr("Fra&mes to make"), rate_);
  judge_ =
      named(new QCheckBox(tr("&Judge the quality on held-out frames (twice the time)"), this), "motionJudge",
            tr("A second fit leaves out every few frames and is compared on them with linear\n"
               "interpolation in time and with the previous frame."));
  judge_->setChecked(true);
  form->addRow(judge_);
  device_ = named(new DeviceBox(this), "motionDevice");
  form->addRow(tr("De&vice"), device_);
  std::vector<const Setting*> rows;
  for (const Setting& row : settingsTable())
    if (row.group == Setting::Group::Dynamic && row.name != std::string("kind")) rows.push_back(&row);
  for (const char* name : {"gaussians", "seed"})
    rows.push_back(&settingNamed(name));
  settings_ = new SettingsPanel(rows, this);
  auto* section = new Section(tr("Advanced &settings"), this);
  section->setContent(settings_);
  form->addRow(section);
  layout->addWidget(options_);
  run_ = named(new QPushButton(tr("Reconstruct"), this), "motionRun");
  layout->addWidget(run_);
  bar_ = named(new QProgressBar(this), "motionProgress");
  bar_->setRange(0, 1000);
  layout->addWidget(bar_);
  phase_ = makeWrappedLabel(QStringLiteral("motionPhase"), this);
  layout->addWidget(phase_);
  quality_ = makeWrappedLabel(QStringLiteral("motionQuality"), this);
  quality_->setTextFormat(Qt::RichText);
  layout->addWidget(quality_);
  return box;
}

QWidget* MotionPanel::buildView() {
  auto* box = new QGroupBox(tr("Look at any time"), this);
  auto* layout = new QVBoxLayout(box);
  auto* choice = new QFormLayout;
  model_ =
      named(host_->createSelector(Host::Role::Model, this), "motionModel", tr("A model of a dynamic scan."));
  choice->addRow(tr("M&odel"), model_);
  layout->addLayout(choice);
  aboutModel_ = makeWrappedLabel(QStringLiteral("motionAboutModel"), this);
  layout->addWidget(aboutModel_);
  view_ = new QWidget(box);
  auto* controls = layoutWithoutMargins<QVBoxLayout>(view_);
  auto* line = new QHBoxLayout;
  play_ = named(new QToolButton(this), "motionPlay", tr("Play in a loop."));
  play_->setCheckable(true);
  play_->setIcon(style()->standardIcon(QStyle::SP_MediaPlay));
  play_->setAccessibleName(tr("Play"));
  line->addWidget(play_);
  time_ = new ValueSlider(tr(" s"), 3, this);
  time_->describe(QStringLiteral("motionTime"), tr("Time"),
                  tr("The time at which the slice views and the query's plane show the model."));
  line->addWidget(time_, 1);
  speed_ = named(new QComboBox(this), "motionSpeed", tr("Playback speed."));
  speed_->setAccessibleName(tr("Speed"));
  for (const double speed : {0.25, 0.5, 1., 2., 4.})
    speed_->addItem(tr("%1×").arg(QLocale().toString(speed)), speed);
  speed_->setCurrentIndex(2);
  line->addWidget(speed_);
  controls->addLayout(line);
  auto* buttons = new QHBoxLayout;
  saveFrames_ = named(new QPushButton(tr("Save Fr&ames…"), this), "motionSaveFrames",
                      tr("Frames at the rate chosen above as one 4D NIfTI or .seq.nrrd file."));
  saveFrames_->setVisible(motion_->savesFrames());
  saveModel_ = named(new QPushButton(tr("Save Mo&del…"), this), "motionSaveModel",
                     tr("The model (.innergs), which renders frames at any time."));
  buttons->addStretch(1);
  buttons->addWidget(saveFrames_);
  buttons->addWidget(saveModel_);
  controls->addLayout(buttons);
  layout->addWidget(view_);
  return box;
}

void MotionPanel::connectAll() {
  connect(series_, &Selector::currentIdChanged, this, &MotionPanel::showSeries);
  connect(host_, &Host::volumesChanged, this, &MotionPanel::showSeries);
  connect(model_, &Selector::currentIdChanged, this, &MotionPanel::showModel);
  connect(host_, &Host::modelsChanged, this, &MotionPanel::showModel);
  connect(interval_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, &MotionPanel::showSeries);
  connect(run_, &QPushButton::clicked, this, &MotionPanel::startOrCancel);
  connect(motion_, &MotionHost::started, this, [this] {
    cancelling_ = false;
    message_->say({});
    quality_->hide();
    ended();
    showProgress({});
  });
  connect(motion_, &MotionHost::previewed, this, &MotionPanel::showModel);
  connect(kind_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
    Settings settings = settings_->settings();
    settingNamed("kind").setText(settings, kind_->currentData().toString().toStdString());
    settings_->setSettings(settings);
    const bool times = !settings.kind || settings.kind == DynamicKind::Intensity;
    sliceTimes_->parentWidget()->setEnabled(times);
  });
  connect(motion_, &MotionHost::progressed, this, &MotionPanel::showProgress);
  connect(recovery_, &RecoveryLine::chosen, this, &MotionPanel::goOn);
  connect(motion_, &MotionHost::finished, this, [this](const MotionReport& report) {
    recovery_->setFile({}); // the fit is complete
    ended();
    showReport(report);
  });
  connect(motion_, &MotionHost::failed, this, [this](const QString& sentence) {
    ended();
    message_->say(sentence, true);
  });
  connect(motion_, &MotionHost::cancelled, this, [this] {
    ended();
    message_->say(recovery_->isHidden() ? tr("Cancelled: nothing was changed.") : tr("Cancelled."));
  });
  connect(motion_, &MotionHost::timeChanged, this, [this](const QString& id, double now) {
    if (id != modelId() || previewing_ || play_->isChecked()) return;
    info_.now = now;
    time_->setValue(now);
  });
  connect(time_, &ValueSlider::valueEdited, this, [this](double now) {
    if (play_->isChecked()) play_->setChecked(false);
    info_.now = now;
    showAt(now);
  });
  connect(play_, &QToolButton::toggled, this, &MotionPanel::play);
  connect(&frames_, &QTimer::timeout, this, &MotionPanel::advance);
  connect(speed_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
    if (play_->isChecked()) play(true); // from where it is
  });
  connect(saveFrames_, &QPushButton::clicked, this, &MotionPanel::saveFrames);
  connect(saveModel_, &QPushButton::clicked, this, &MotionPanel::saveModel);
}

void MotionPanel::setSeriesId(const QString& id) {
  series_->setCurrentId(id);
}

QString MotionPanel::modelId() const {
  return model_->currentId();
}

void MotionPanel::setModelId(const QString& id) {
  model_->setCurrentId(id);
  showModel();
}

MotionRequest MotionPanel::request() const {
  MotionRequest request;
  request.seriesId = series_->currentId();
  request.interval = interval_->number().value_or(0);
  request.settings = settings_->settings();
  request.settings.device = device_->device().toStdString();
  if (sliceTimes_->isEnabled()) request.sliceTimesFile = sliceTimes_->text().trimmed();
  request.rate = rate_->number().value_or(0);
  request.evaluateQuality = judge_->isChecked();
  request.resumeFile = recovery_->file();
  return request;
}

void MotionPanel::chooseSliceTimes() {
  askForFile(this, host_, "motionSliceTimesDialog", tr("Slice times"),
             tr("Slice times (*.json *.txt);;All files (*)"),
             [this](const QString& file) { sliceTimes_->setText(QDir::toNativeSeparators(file)); });
}

void MotionPanel::goOn(const RecoveredFit& fit) {
  const std::string kind = settingNamed("kind").textIn(fit.settings);
  kind_->setCurrentIndex(std::max(0, kind_->findData(QString::fromStdString(kind))));
  settings_->setSettings(fit.settings);
  device_->setDevice(QString::fromStdString(fit.settings.device));
  interval_->setValue(fit.interval > 0 ? fit.interval : interval_->minimum());
}

void MotionPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (!motion_->isRunning()) recovery_->refresh(); // another program may have left something
}

void MotionPanel::showSeries() {
  const SeriesInfo info = motion_->seriesInfo(series_->currentId());
  QString text;
  if (info.name.isEmpty())
    text = tr("Open a scan with several frames: 4D NIfTI, MINC or .seq.nrrd.");
  else if (!info.problem.isEmpty())
    text = info.problem;
  else {
    text = tr("%n frames of %1 × %2 × %3 voxels", nullptr, info.frames)
               .arg(info.dimensions[0])
               .arg(info.dimensions[1])
               .arg(info.dimensions[2]);
    const auto interval = interval_->number();
    const double last = interval ? (info.frames - 1) * *interval : info.last,
                 first = interval ? 0 : info.first;
    text += last > first             ? tr(", from %1 s to %2 s.").arg(seconds(first), seconds(last))
            : info.timed || interval ? QStringLiteral(".")
                                     : tr(". The scan has no frame times: give the time between frames.");
  }
  about_->setText(text);
  run_->setEnabled(motion_->isRunning() || (!info.name.isEmpty() && info.problem.isEmpty()));
}

void MotionPanel::showModel() {
  const QString id = modelId();
  const MotionInfo before = info_;
  const bool previewedBefore =
      std::exchange(previewing_, motion_->isRunning() && motion_->previewInfo().known);
  info_ = previewing_ ? motion_->previewInfo() : motion_->motionInfo(id);
  if (previewing_ != previewedBefore) play_->setChecked(false);
  view_->setEnabled(info_.known);
  for (QPushButton* button : {saveFrames_, saveModel_})
    button->setEnabled(!previewing_);
  if (!info_.known) {
    play_->setChecked(false);
    aboutModel_->setText(id.isEmpty() ? tr("No model of a dynamic scan yet.")
                                      : tr("This model does not move: it shows a single moment."));
    return;
  }
  if (previewing_)
    aboutModel_->setText(
        tr("The model so far, %1 s to %2 s.").arg(seconds(info_.first), seconds(info_.last)));
  else
    aboutModel_->setText((info_.kind == QLatin1String("intensity")
                              ? tr("Gaussians that change their intensity, %1 s to %2 s.")
                              : tr("Gaussians that move, %1 s to %2 s."))
                             .arg(seconds(info_.first), seconds(info_.last)));
  if (info_.first != before.first || info_.last != before.last || !before.known) {
    time_->setRange(info_.first, info_.last);
    time_->setSingleStep((info_.last - info_.first) / 100);
  }
  if (!time_->slider()->isSliderDown() && !play_->isChecked()) time_->setValue(info_.now);
  if (previewing_ || id == modelId_) return;
  modelId_ = id;
  Q_EMIT modelIdChanged(id);
}

void MotionPanel::showProgress(const Progress& progress) {
  bar_->setValue(static_cast<int>(std::lround(1000 * progress.fraction)));
  if (cancelling_) {
    phase_->setText(tr("Cancelling…"));
    return;
  }
  QString text = phaseText(progress.phase);
  if (progress.remaining >= 1) text += tr(", %1 left").arg(roughDuration(progress.remaining));
  if (!progress.note.empty()) device_->setReason(QString::fromStdString(progress.note));
  phase_->setText(text);
}

void MotionPanel::ended() {
  const bool running = motion_->isRunning();
  options_->setEnabled(!running);
  run_->setText(running ? tr("Cancel") : tr("Reconstruct"));
  bar_->setVisible(running);
  phase_->setVisible(running);
  if (running) {
    recovery_->hide();
    run_->setEnabled(true);
  } else {
    recovery_->refresh();
    showSeries();
  }
  showModel();
}

void MotionPanel::showReport(const MotionReport& report) {
  setModelId(report.modelId);
  QStringList lines{
      tr("Done in %1. %2").arg(exactDuration(report.seconds), sentence(gaussiansText(report.gaussians)))};
  if (!report.choice.isEmpty()) lines << report.choice;
  lines << report.warnings;
  message_->say(lines.join(QLatin1Char('\n')));
  quality_->setVisible(!report.quality.isEmpty());
  if (report.quality.isEmpty()) return;
  const QString cell = QStringLiteral("<td align=right style='padding-left:%1px'>%2</td>")
                           .arg(2 * fontMetrics().averageCharWidth());
  QString rows =
      QStringLiteral("<tr><td style='white-space:nowrap'><b>%1</b></td>%2%3</tr>")
          .arg(tr("On held-out frames"), cell.arg(tr("<b>PSNR&nbsp;(dB)</b>")), cell.arg(tr("<b>SSIM</b>")));
  const QLocale locale;
  for (const QualityRow& row : report.quality) {
    const QString name = row.method == QLatin1String("previous") ? tr("Previous frame")
                         : row.isOurs()                          ? methodText(row.method)
                                                                 : tr("Linear in time");
    const QString bold = row.isOurs() ? QStringLiteral("<b>%1</b>") : QStringLiteral("%1");
    rows += QStringLiteral("<tr><td style='white-space:nowrap'>%1</td>%2%3</tr>")
                .arg(bold.arg(name.toHtmlEscaped()), cell.arg(bold.arg(locale.toString(row.psnr, 'f', 2))),
                     cell.arg(bold.arg(locale.toString(row.ssim, 'f', 4))));
  }
  quality_->setText(QStringLiteral("<table width='100%' cellspacing='0' cellpadding='1'>%1</table>"
                                   "<p style='margin-top:6px; margin-bottom:0'>%2</p>")
                        .arg(rows, tr("Scored on %1").arg(report.samples).toHtmlEscaped()));
}

void MotionPanel::startOrCancel() {
  if (!motion_->isRunning()) {
    motion_->start(request());
    return;
  }
  cancelling_ = true;
  phase_->setText(tr("Cancelling…"));
  run_->setEnabled(false);
  motion_->cancel();
}

void MotionPanel::play(bool on) {
  play_->setIcon(style()->standardIcon(on ? QStyle::SP_MediaPause : QStyle::SP_MediaPlay));
  play_->setAccessibleName(on ? tr("Pause") : tr("Play"));
  if (!on || !info_.known) return frames_.stop();
  playedFrom_ = info_.now >= info_.last ? info_.first : info_.now;
  playing_.start();
  frames_.start(kPlayInterval);
}

void MotionPanel::showAt(double time) {
  if (previewing_)
    motion_->setPreviewTime(time);
  else
    motion_->setTime(modelId(), time);
}

void MotionPanel::advance() {
  const double length = info_.last - info_.first;
  if (!info_.known || !(length > 0)) return play_->setChecked(false);
  const double gone = 1e-3 * static_cast<double>(playing_.elapsed()) * speed_->currentData().toDouble();
  info_.now = info_.first + std::fmod(playedFrom_ - info_.first + gone, length);
  time_->setValue(info_.now);
  showAt(info_.now);
}

void MotionPanel::saveFrames() {
  askWhereToSave(this, host_, "motionFramesDialog", tr("Save the frames"),
                 tr("NIfTI, compressed (*.nii.gz);;NIfTI (*.nii);;3D Slicer's sequence (*.seq.nrrd)"),
                 host_->modelInfo(modelId()).name + tr(" frames") + QStringLiteral(".nii.gz"),
                 [this](const QString& file) {
                   saySaved(file, motion_->saveFrames(modelId(), rate_->number().value_or(0), file));
                 });
}

void MotionPanel::saveModel() {
  askWhereToSave(this, host_, "motionModelDialog", tr("Save the model"), tr("InnerGS model (*.innergs)"),
                 host_->modelInfo(modelId()).name + QStringLiteral(".innergs"),
                 [this](const QString& file) { saySaved(file, host_->saveModel(modelId(), file)); });
}

void MotionPanel::saySaved(const QString& file, const QString& error) {
  message_->say(error.isEmpty() ? tr("Saved to '%1'.").arg(QDir::toNativeSeparators(file)) : error,
                !error.isEmpty());
}

} // namespace innergs::ui
