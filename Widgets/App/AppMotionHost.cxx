#include "Widgets/App/AppMotionHost.h"

#include "Core/Base/Error.h"
#include "Core/Base/ThreadPriority.h"
#include "Core/Motion/FrameRenderer.h"
#include "Core/Render/Render.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/RecoveredFit.h"
#include "IO/TimeSeriesIO.h"
#include "IO/TimeSeriesWriting.h"
#include "Widgets/App/AppHost.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"

#include <QFileInfo>
#include <QMetaObject>

#include <algorithm>
#include <utility>

namespace innergs::app {

AppMotionHost::AppMotionHost(AppHost* host)
    : ui::MotionHost(host), host_(host), frames_(new Background(this)) {}

AppMotionHost::~AppMotionHost() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

ui::SeriesInfo AppMotionHost::seriesInfo(const QString& id) const {
  ui::SeriesInfo info;
  const auto item = host_->document().volume(id);
  if (!item || item->frames.count < 2) return info;
  info.name = item->name;
  info.frames = item->frames.count;
  for (int a = 0; a < 3; ++a)
    info.dimensions[a] = static_cast<int>(item->volume->geometry.size[a]);
  const std::filesystem::path file = pathOf(item->frames.file);
  std::error_code ignored;
  info.timed = item->frames.seconds > 0 || std::filesystem::exists(sidecarOf(file), ignored) ||
               !frameFiles(file).empty() ||
               item->frames.file.endsWith(QLatin1String(".seq.nrrd"), Qt::CaseInsensitive);
  info.last = item->frames.seconds * (item->frames.count - 1);
  return info;
}

bool AppMotionHost::start(const ui::MotionRequest& request) {
  const auto item = host_->document().volume(request.seriesId);
  QString refusal;
  if (running_ || host_->isRunning())
    refusal = tr("A reconstruction is running: wait for it or cancel it.");
  else if (!item || item->frames.count < 2)
    refusal = tr("There is no dynamic scan: open a 4D file and choose it.");
  if (refusal.isEmpty()) {
    if (thread_.joinable()) thread_.join(); // at its end
    running_ = true;
    ++run_;
    previewShown_ = {{}, item->window, nameOf(item->frames.file)};
    latest_.clear();
    refusal = sentenceOf([&] {
      thread_ = std::jthread(
          [this, request, scan = *item](const std::stop_token& stop) { work(request, scan, stop); });
    });
    if (!refusal.isEmpty()) running_ = false;
  }
  if (!refusal.isEmpty()) {
    Q_EMIT failed(refusal);
    return false;
  }
  Q_EMIT started();
  return true;
}

void AppMotionHost::cancel() {
  if (running_) thread_.request_stop();
}

void AppMotionHost::post(const Progress& progress) {
  if (!latest_.put(progress)) return;
  QMetaObject::invokeMethod(
      this,
      [this] {
        const auto progress = latest_.take();
        if (!progress || !running_) return;
        if (!progress->note.empty()) Q_EMIT host_->logged(QString::fromStdString(progress->note));
        Q_EMIT progressed(*progress);
      },
      Qt::QueuedConnection);
}

/// On the worker: the state of a stopped fit, if it can be continued. Throws Error.
void AppMotionHost::keep(const ui::MotionRequest& request, const VolumeItem& scan,
                         const DynamicResult& result) {
  RecoveredFit about;
  about.inputs = nameOf(scan.frames.file).toStdString();
  about.settings = request.settings;
  about.interval = request.interval;
  const std::filesystem::path folder = pathOf(recoveryFolder());
  writeStoppedFit(result, about, folder);
  if (!about.file.empty()) dropRecoveredFit(pathOf(request.resumeFile), folder);
}

void AppMotionHost::work(const ui::MotionRequest& request, const VolumeItem& scan,
                         const std::stop_token& stop) {
  lowerThreadPriority(); // the windows have priority
  const auto outcome = std::make_shared<Outcome>();
  bool stopped = false;
  const QString error = sentenceOf([&] {
    post({});
    TimeSeriesOptions reading;
    if (request.interval > 0) reading.interval = request.interval;
    reading.sliceTimes = pathOf(request.sliceTimesFile);
    TimeSeries series = readTimeSeries(pathOf(scan.frames.file), reading);
    timesAtRate(request.rate, series.times); // throws if the rate is invalid
    const std::string pairs = remarkOnPairs(series);
    JudgedSeries job(std::move(series), request.settings, request.evaluateQuality);
    if (!request.resumeFile.isEmpty()) job.resume(readStoppedFit(pathOf(request.resumeFile)));
    job.onProgress([&](const Progress& progress) { post(progress); });
    job.onPreview([this](const auto& field) {
      QMetaObject::invokeMethod(
          this, [this, field] { receivePreview(field); }, Qt::QueuedConnection);
    });
    const JudgedSeriesResult made = job.run(stop);
    if (made.result.cancelled || !made.result.field) {
      keep(request, scan, made.result);
      stopped = true;
      return;
    }
    dropRecoveredFit(pathOf(request.resumeFile), pathOf(recoveryFolder()));
    ui::MotionReport& report = outcome->report;
    report.choice = QString::fromStdString(made.result.choice);
    for (const std::string& sentence : {pairs, made.note})
      if (!sentence.empty()) report.warnings << QString::fromStdString(sentence);
    for (const std::string& note : made.result.notes)
      report.warnings << QString::fromStdString(note);
    if (made.quality) {
      for (const MethodScore& score : made.quality->methods)
        report.quality.push_back({QString::fromStdString(score.name), score.psnr, score.ssim});
      report.samples = QString::fromStdString(made.quality->samples);
    }
    report.gaussians = made.result.field->size();
    report.seconds = made.result.seconds;
    const QString name = nameOf(scan.frames.file);
    outcome->model = makeItem(made.result.field, tr("%1 model").arg(name), {},
                              notesOf(made.result, scan.name.toStdString()));
    outcome->model.origin = name;
    outcome->model.window = {scan.window->lower, scan.window->upper};
    outcome->model.saved = false;
  });
  QMetaObject::invokeMethod(
      this,
      [this, outcome, stopped, error] {
        if (thread_.joinable()) thread_.join(); // at its end
        running_ = false;
        preview_ = nullptr;
        if (stopped || !error.isEmpty()) dropPreview();
        if (stopped) {
          Q_EMIT cancelled();
        } else if (!error.isEmpty()) {
          Q_EMIT host_->logged(error);
          Q_EMIT failed(error);
        } else {
          deliver(*outcome);
        }
      },
      Qt::QueuedConnection);
}

void AppMotionHost::deliver(Outcome& outcome) {
  const Shown shown = std::exchange(previewShown_, {});
  const double first = shown.volumeId.isEmpty() ? outcome.model.time : previewTime_;
  outcome.report.modelId = host_->document().add(std::move(outcome.model));
  shown_[outcome.report.modelId] = shown;
  Q_EMIT host_->logged(tr("Fitted a model in space and time to %1.").arg(shown.scan));
  setTime(outcome.report.modelId, first);
  Q_EMIT finished(outcome.report);
}

ui::MotionInfo AppMotionHost::motionInfo(const QString& modelId) const {
  const auto item = host_->document().model(modelId);
  return item ? ui::motionInfoOf(item->dynamic, asked_.value(modelId, item->time)) : ui::MotionInfo();
}

void AppMotionHost::receivePreview(const std::shared_ptr<const DynamicField>& field) {
  if (!running_) return; // from a fit that has ended
  const bool first = !preview_;
  preview_ = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
  preview_->SetField(field);
  if (first) previewTime_ = field->times.front();
  setPreviewTime(previewTime_);
  Q_EMIT previewed();
}

ui::MotionInfo AppMotionHost::previewInfo() const {
  return ui::motionInfoOf(preview_, previewTime_);
}

void AppMotionHost::setPreviewTime(double seconds) {
  previewTime_ = seconds;
  wanted_ = Wanted{{}, seconds};
  if (!showing_) showWanted();
}

/// After a fit that gave no model.
void AppMotionHost::dropPreview() {
  const QString id = std::exchange(previewShown_, {}).volumeId;
  if (!id.isEmpty()) host_->document().remove(id);
}

void AppMotionHost::setTime(const QString& modelId, double seconds) {
  wanted_ = Wanted{modelId, seconds};
  asked_[modelId] = seconds;
  if (!showing_) showWanted();
}

void AppMotionHost::showWanted() {
  if (!wanted_) return;
  const Wanted wanted = *std::exchange(wanted_, std::nullopt);
  const bool preview = wanted.modelId.isEmpty();
  const auto item = host_->document().model(wanted.modelId);
  const vtkSmartPointer<vtkInnerGSDynamicModel> dynamic = preview ? preview_ : item ? item->dynamic : nullptr;
  if (!dynamic) return;
  showing_ = true;
  const QString scan = preview ? previewShown_.scan : shown_.value(wanted.modelId).scan;
  const QString name = tr("%1 in time").arg(scan.isEmpty() && item ? item->name : scan);
  frames_->run({}, [this, wanted, name, dynamic, preview, run = run_] {
    const auto model = std::make_shared<vtkSmartPointer<vtkInnerGSModel>>();
    const auto volume = std::make_shared<VolumeItem>();
    const QString error = sentenceOf([&] {
      double range[2] = {wanted.time, wanted.time};
      dynamic->GetTimeRange(range);
      *model = vtkSmartPointer<vtkInnerGSModel>::Take(
          dynamic->NewModelAt(std::clamp(wanted.time, range[0], range[1])));
      if (!*model) throw Error(ErrorCode::InvalidArgument, tr("This time cannot be shown.").toStdString());
      const GaussianField& field = (*model)->GetCoreModel()->field;
      *volume = makeItem(render(field, field.region()), name);
      volume->role = VolumeRole::Made; // the model can make it again, so it need not be saved
    });
    return [this, wanted, dynamic, model, volume, error, preview, run] {
      showing_ = false;
      if (preview && error.isEmpty() && running_ && run == run_) {
        volume->window = previewShown_.window;
        if (!host_->document().replace(previewShown_.volumeId, *volume))
          previewShown_.volumeId = host_->document().add(std::move(*volume));
        Q_EMIT frameShown(previewShown_.volumeId);
      }
      const auto now = host_->document().model(wanted.modelId);
      if (!error.isEmpty()) Q_EMIT host_->logged(error);
      if (error.isEmpty() && now && now->dynamic == dynamic) {
        Shown& shown = shown_[wanted.modelId];
        if (shown.window) volume->window = shown.window;
        if (!host_->document().replace(shown.volumeId, *volume)) {
          shown.volumeId = host_->document().add(std::move(*volume));
          if (!shown.window) shown.window = host_->document().volume(shown.volumeId)->window;
        }
        ModelItem posed = *now;
        posed.model = *model;
        posed.time = wanted.time;
        host_->document().replace(wanted.modelId, std::move(posed));
        Q_EMIT frameShown(shown.volumeId);
      }
      showWanted();
    };
  });
}

QString AppMotionHost::saveFrames(const QString& modelId, double rate, const QString& file) {
  const auto item = host_->document().model(modelId);
  if (!item || !item->dynamic) return tr("The model is no longer open and its frames cannot be saved.");
  for (const auto& volume : host_->document().volumes())
    if (volume->frames.count > 1 && isSameFile(pathOf(volume->frames.file), pathOf(file)))
      return tr("'%1' is the dynamic scan that is open as '%2': choose another file.")
          .arg(file, volume->name);
  QString error;
  host_->background().runAndWait(tr("Saving %1").arg(QFileInfo(file).fileName()), [&] {
    error = sentenceOf([&] {
      const auto field = item->dynamic->GetField();
      TimeSeries series{field->canonical.region(), {}, timesAtRate(rate, field->times), {}, {}};
      checkTimeSeriesPath(pathOf(file));
      FrameRenderer renderer(*field, series.geometry, {});
      for (const double time : series.times)
        series.frames.push_back(renderer.at(time));
      writeTimeSeries(series, pathOf(file));
    });
  });
  Q_EMIT host_->logged(error.isEmpty() ? tr("Wrote %1.").arg(file) : error);
  return error;
}

} // namespace innergs::app
