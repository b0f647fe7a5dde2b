#include "Widgets/App/AppHost.h"

#include "Core/Acquisition/SliceOrder.h"
#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/Devices.h"
#include "Core/Job/JobOutline.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/RequestErrors.h"
#include "Core/Settings/SettingsTable.h"
#include "Geometry.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/SliceFiles.h"
#include "ImageVoxels.h"
#include "Widgets/App/AppMotionHost.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"
#include "Widgets/App/SegmentItems.h"
#include "Widgets/App/VolumeSelector.h"

#include <QDir>
#include <QFileInfo>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <algorithm>

namespace innergs::app {

namespace {

[[noreturn]] void refuse(const QString& sentence) {
  throw Error(ErrorCode::InvalidArgument, sentence.toStdString());
}

} // namespace

AppHost::AppHost(QObject* parent)
    : Host(parent), background_(new Background(this)), runner_(new Runner(this)),
      motion_(new AppMotionHost(this)), estimates_(new Background(this)),
      forecasts_([this](Background::Work work) { estimates_->run({}, std::move(work)); },
                 [this] { Q_EMIT estimateChanged(); }) {
  qRegisterMetaType<innergs::Progress>();
  qRegisterMetaType<innergs::ui::Report>();
  connect(&document_, &Document::volumesChanged, this, &AppHost::volumesChanged);
  connect(&document_, &Document::modelsChanged, this, &AppHost::modelsChanged);
  connect(runner_, &Runner::progressed, this, &AppHost::progressed);
  connect(runner_, &Runner::previewed, this, &AppHost::previewed);
  for (Background* thread : {background_, estimates_})
    connect(thread, &Background::failed, this, &AppHost::logged);
  const auto ended = [this] { forecasts_.runEnded(); }; // before anyone hears of it
  connect(runner_, &Runner::finished, this, ended);
  connect(runner_, &Runner::failed, this, ended);
  connect(runner_, &Runner::cancelled, this, ended);
  connect(runner_, &Runner::finished, this,
          [this](const std::shared_ptr<Outcome>& outcome) { deliver(std::move(*outcome)); });
  connect(runner_, &Runner::failed, this, &AppHost::failed);
  connect(runner_, &Runner::cancelled, this, &AppHost::cancelled);
}

AppHost::~AppHost() {
  delete motion_; // its threads look at the document
  disconnect(&document_, nullptr, this, nullptr);
}

ui::MotionHost* AppHost::motion() {
  return motion_;
}

bool AppHost::offers(Role role) const {
  return role != Role::Region && role != Role::SlicePoses; // its files say where slices lie
}

ui::Selector* AppHost::createSelector(Role role, QWidget* parent) {
  return offers(role) ? new VolumeSelector(&document_, role, parent) : nullptr;
}

ui::VolumeInfo AppHost::volumeInfo(const QString& id) const {
  ui::VolumeInfo info;
  const auto item = document_.volume(id);
  if (!item) return info;
  info.name = item->name;
  const GridGeometry& geometry = item->volume->geometry;
  for (int a = 0; a < 3; ++a) {
    info.dimensions[a] = static_cast<int>(geometry.size[a]);
    info.spacing[a] = geometry.spacing[a];
  }
  info.sliceAxis = item->sliceAxis;
  info.orientation = orientationOf(geometry, item->sliceAxis);
  info.sliceThickness = item->thickness;
  info.hasPoses = !item->poses.empty();
  info.passes = item->times.empty() ? 0 : interleavedPasses(item->times);
  return info;
}

//------------------------------------------------------------------------------
// Models.

ui::ModelInfo AppHost::modelInfo(const QString& id) const {
  ui::ModelInfo info;
  const auto item = document_.model(id);
  if (!item) return info;
  info.name = item->name;
  info.gaussians = item->model->GetNumberOfGaussians();
  info.bytes = static_cast<std::int64_t>(item->model->GetActualMemorySize()) * 1024;
  info.description =
      QString::fromStdString(item->dynamic ? item->dynamic->GetDescription() : item->model->GetDescription());
  item->model->GetBounds(info.bounds.data());
  info.window = item->window;
  const GridGeometry& domain = item->model->GetField()->domain;
  if (domain.voxelCount() > 0) info.finestSpacing = domain.finestSpacing();
  info.saved = item->saved;
  info.origin = item->origin;
  info.file = item->file;
  info.ellipsoidsShown = item->ellipsoidsShown;
  info.ellipsoids = item->ellipsoids;
  return info;
}

vtkInnerGSModel* AppHost::model(const QString& id) const {
  const auto item = document_.model(id);
  return item ? item->model.Get() : nullptr;
}

QString AppHost::loadModel(const QString& file, QString* error) {
  Loaded loaded;
  QString sentence;
  if (!isModelFile(file))
    sentence = tr("'%1' is not a model: choose a file that ends in .innergs or .ply.").arg(file);
  else
    background_->runAndWait(tr("Opening %1").arg(QFileInfo(file).fileName()),
                            [&] { sentence = sentenceOf([&] { loaded = readItem(file); }); });
  if (error) *error = sentence;
  if (!sentence.isEmpty()) {
    Q_EMIT logged(sentence);
    return {};
  }
  QString id = document_.add(std::move(*loaded.model));
  Q_EMIT opened(id, file);
  return id;
}

QString AppHost::saveModel(const QString& id, const QString& file) {
  return save(id, file);
}

QString AppHost::save(const QString& id, const QString& file) {
  // Copies that share the content: the document's items may be replaced while the thread writes.
  std::optional<VolumeItem> volume;
  std::optional<ModelItem> model;
  if (const auto item = document_.volume(id)) volume = *item;
  if (const auto item = document_.model(id)) model = *item;
  QString sentence;
  if (!volume && !model) sentence = tr("This item is no longer open and cannot be saved.");
  for (const auto& item : document_.volumes())
    if (item->frames.count > 1 && isSameFile(pathOf(item->frames.file), pathOf(file)))
      sentence = tr("'%1' is the file of '%2', with all its %n frames: choose another file.", nullptr,
                    item->frames.count)
                     .arg(file, item->name);
  if (sentence.isEmpty())
    background_->runAndWait(tr("Saving %1").arg(QFileInfo(file).fileName()), [&] {
      sentence = sentenceOf([&] {
        if (volume) saveItem(*volume, file);
        if (model) saveItem(*model, file);
      });
    });
  Q_EMIT logged(sentence.isEmpty() ? tr("Wrote %1.").arg(file) : sentence);
  if (!sentence.isEmpty()) return sentence;
  const auto volumeNow = document_.volume(id);
  const auto modelNow = document_.model(id);
  const bool same = (volume && volumeNow && volumeNow->volume == volume->volume) ||
                    (model && modelNow && modelNow->dynamic == model->dynamic &&
                     (model->dynamic || modelNow->model == model->model));
  if (same && !(model && isPly(file))) document_.setSaved(id, file);
  return {};
}

QString AppHost::showEllipsoids(const QString& id, bool shown) {
  if (!document_.model(id)) return tr("The model is no longer open: choose another.");
  document_.setEllipsoidsShown(id, shown);
  return {};
}

//------------------------------------------------------------------------------
// Files.

void AppHost::open(const QStringList& paths) {
  for (const QString& path : paths) {
    if (path.isEmpty()) continue;
    background_->run(tr("Opening %1").arg(QFileInfo(QDir::cleanPath(path)).fileName()), [this, path] {
      auto loaded = std::make_shared<std::vector<Loaded>>();
      QStringList leftOut;
      const QString sentence = sentenceOf([&] { *loaded = readItems(path, &leftOut); });
      return [this, path, loaded, leftOut, sentence] {
        if (!sentence.isEmpty()) {
          Q_EMIT logged(sentence);
          Q_EMIT openFailed(path, sentence);
          return;
        }
        QString first;
        for (Loaded& item : *loaded) {
          const QString id =
              item.volume ? document_.add(std::move(*item.volume)) : document_.add(std::move(*item.model));
          if (first.isEmpty()) first = id;
        }
        Q_EMIT logged(
            loaded->size() == 1
                ? tr("Opened %1.").arg(path)
                : tr("Opened %n series of %1.", nullptr, static_cast<int>(loaded->size())).arg(path));
        for (const QString& line : leftOut)
          Q_EMIT logged(line);
        if (const auto item = document_.volume(first); item && !item->note.isEmpty())
          Q_EMIT logged(item->note);
        Q_EMIT opened(first, path);
      };
    });
  }
}

void AppHost::showFrame(const QString& id, int frame) {
  const auto item = document_.volume(id);
  if (!item || frame < 0 || frame >= item->frames.count) return;
  const bool reading = wantedFrames_.contains(id);
  if (!reading && frame == item->frames.shown) return;
  wantedFrames_[id] = frame;
  if (!reading) readWantedFrame(id);
}

void AppHost::replaceVolume(const VolumeItem& before, VolumeItem item, const QString& name) {
  const QString id = before.id; // replace() overwrites `before`
  item.window = before.window;
  item.role = before.role;
  document_.replace(id, std::move(item));
  document_.rename(id, name);
}

void AppHost::readWantedFrame(const QString& id) {
  const auto item = document_.volume(id);
  const int frame = wantedFrames_.value(id);
  if (!item || frame == item->frames.shown) {
    wantedFrames_.remove(id);
    return;
  }
  const QString file = item->frames.file;
  background_->run(
      tr("Reading frame %1 of %2").arg(frame + 1).arg(QFileInfo(file).fileName()), [this, id, file, frame] {
        auto loaded = std::make_shared<Loaded>();
        const QString sentence = sentenceOf([&] { *loaded = readItem(file, frame); });
        return [this, id, file, frame, loaded, sentence] {
          const auto now = document_.volume(id);
          if (!sentence.isEmpty() || !now || now->frames.file != file) {
            wantedFrames_.remove(id);
            if (sentence.isEmpty()) return;
            Q_EMIT logged(sentence);
            Q_EMIT openFailed(file, sentence);
            return;
          }
          replaceVolume(*now, std::move(*loaded->volume), nameOfFrame(now->name, now->frames.shown, frame));
          Q_EMIT frameShown(id);
          readWantedFrame(id);
        };
      });
}

void AppHost::calibrate(const QString& id, const QString& calibration) {
  const auto item = document_.volume(id);
  if (!item) return;
  const QString file = item->file;
  background_->run(tr("Placing the images of %1").arg(item->name), [this, id, file, calibration] {
    auto loaded = std::make_shared<Loaded>();
    const QString sentence = sentenceOf([&] { *loaded = readItem(file, 0, {}, calibration); });
    return [this, id, file, loaded, sentence] {
      const auto now = document_.volume(id);
      if (!sentence.isEmpty()) {
        Q_EMIT logged(sentence);
        Q_EMIT openFailed(file, sentence);
      }
      if (!sentence.isEmpty() || !now) return;
      const QString name = now->name, note = loaded->volume->note;
      replaceVolume(*now, std::move(*loaded->volume), name);
      Q_EMIT logged(note);
      Q_EMIT opened(id, file);
    };
  });
}

void AppHost::openSample(const QString& head) {
  const QString brain = head.isEmpty() ? sampleBrain() : head;
  background_->run(tr("Opening the sample brain"), [this, brain, head] {
    auto items = std::make_shared<std::vector<VolumeItem>>();
    const QString sentence =
        brain.isEmpty() ? whatIsTheSampleBrain() : sentenceOf([&] { *items = makeSample(brain); });
    return [this, items, sentence, head, brain] {
      if (!sentence.isEmpty()) {
        Q_EMIT logged(sentence);
        Q_EMIT openFailed(brain, sentence);
        return;
      }
      if (!head.isEmpty()) rememberSampleBrain(head);
      QString first;
      for (VolumeItem& item : *items) {
        const QString id = document_.add(std::move(item));
        if (first.isEmpty()) first = id;
      }
      Q_EMIT logged(tr("Opened the sample: a scan with thick slices made from %1, and that head itself.")
                        .arg(QDir::toNativeSeparators(brain)));
      Q_EMIT opened(first, {});
    };
  });
}

QString AppHost::folder() const {
  return appSettings()->value(QStringLiteral("folder"), QDir::homePath()).toString();
}

QString AppHost::recoveryFolder() const {
  return app::recoveryFolder();
}

void AppHost::setFolder(const QString& folder) {
  appSettings()->setValue(QStringLiteral("folder"), folder);
}

ReconstructionTask AppHost::taskFor(const ui::Request& request) const {
  ReconstructionTask task;
  task.request = request;
  const auto find = [&](const QString& id, const QString& what) {
    const auto item = document_.volume(id);
    if (!item) refuse(tr("%1 is no longer open: choose another.").arg(what));
    return *item;
  };
  for (const ui::InputChoice& choice : request.inputs)
    task.inputs.push_back(find(choice.id, tr("An input")));
  if (task.inputs.empty()) throw noInputError();
  task.recoveryFolder = recoveryFolder();
  task.window = {task.inputs.front().window->lower, task.inputs.front().window->upper};
  const auto findGrid = [&](const QString& id, const QString& what) {
    VolumeItem item = find(id, what);
    if (hasNoGrid(item)) throw noGridError(item);
    return item;
  };
  const auto hasMask = [](const ui::InputChoice& choice) { return !choice.maskId.isEmpty(); };
  if (std::any_of(request.inputs.begin(), request.inputs.end(), hasMask))
    for (const ui::InputChoice& choice : request.inputs) {
      const QString name = document_.nameOf(choice.id);
      const QString id = hasMask(choice) ? choice.maskId : request.maskId;
      if (id.isEmpty()) throw noMaskError(name.toStdString());
      task.masks.push_back(findGrid(id, tr("The mask of '%1'").arg(name)));
    }
  else if (!request.maskId.isEmpty())
    task.masks.push_back(findGrid(request.maskId, tr("The mask")));
  if (request.grid == ui::OutputGrid::Reference) {
    if (request.referenceId.isEmpty()) throw noReferenceError();
    task.reference = findGrid(request.referenceId, tr("The reference volume"));
  }
  if (request.evaluateQuality) checkKeepEvery(request.qualityGap);
  if (!request.outputVolumeId.isEmpty()) {
    const VolumeItem output = find(request.outputVolumeId, tr("The output volume"));
    for (const ui::InputChoice& choice : request.inputs)
      if (choice.id == output.id) throw outputIsInputError(output.name.toStdString());
    if (std::any_of(task.masks.begin(), task.masks.end(),
                    [&](const VolumeItem& mask) { return mask.id == output.id; }) ||
        (request.grid == ui::OutputGrid::Reference && output.id == request.referenceId))
      throw outputIsMaskError(output.name.toStdString());
  }
  if (!request.outputModelId.isEmpty() && !document_.model(request.outputModelId))
    refuse(tr("The output model is no longer open: choose another."));
  checkSettings(request.settings);
  return task;
}

ui::Estimate AppHost::estimate(const ui::Request& request) {
  ui::Estimate estimate;
  estimate.available = availableMemory();
  const QString refusal = sentenceOf([&] {
    const ReconstructionTask task = taskFor(request);
    const JobOutline outline{request.settings, fitOutlines(makeInput(task, false), keepEvery(task))};
    const MemoryNeed need = memoryNeed(outline.fits, outline.settings, estimate.available);
    estimate.memory = need.bytes;
    forecasts_.fill(
        estimate, outline.key(), [outline] { return outline.forecast(); }, isRunning());
    if (!need.refusal.empty() && !isRunning()) throw Error(ErrorCode::Memory, need.refusal);
  });
  if (!refusal.isEmpty()) estimate.refusal = refusal;
  return estimate;
}

bool AppHost::start(const ui::Request& request) {
  QString refusal;
  if (isRunning() || motion_->isRunning())
    refusal = tr("A reconstruction is running: wait for it or cancel it.");
  ReconstructionTask task;
  if (refusal.isEmpty())
    refusal = sentenceOf([&] {
      task = taskFor(request);
      makeInput(task, false);
    });
  if (!refusal.isEmpty()) {
    Q_EMIT failed(refusal);
    return false;
  }
  request_ = request;
  forecasts_.runBegan();
  runner_->start(std::move(task));
  Q_EMIT started();
  return true;
}

void AppHost::deliver(Outcome outcome) {
  ui::Report report = std::move(outcome.report);
  // A chosen output that was closed meanwhile becomes a new one, so no result is lost.
  if (!request_.outputVolumeId.isEmpty() && document_.volume(request_.outputVolumeId)) {
    report.volumeId = request_.outputVolumeId;
    document_.replace(report.volumeId, std::move(outcome.volume));
  } else {
    report.volumeId = document_.add(std::move(outcome.volume));
  }
  if (outcome.uncertainty)
    outcome.model.uncertaintyId = report.uncertaintyId = document_.add(std::move(*outcome.uncertainty));
  if (outcome.measured) document_.add(std::move(*outcome.measured));
  if (!request_.outputModelId.isEmpty() && document_.model(request_.outputModelId)) {
    report.modelId = request_.outputModelId;
    document_.replace(report.modelId, std::move(outcome.model));
  } else {
    report.modelId = document_.add(std::move(outcome.model));
  }
  resultId_ = report.modelId;
  Q_EMIT finished(report);
}

vtkTable* AppHost::sliceTable() const {
  const auto result = document_.model(resultId_);
  return result ? result->sliceTable.Get() : nullptr;
}

QString AppHost::createSliceTransforms(const QString& folder, QString* error) {
  const auto result = document_.model(resultId_);
  const std::vector<FoundSlice> slices = result ? result->slices : std::vector<FoundSlice>{};
  background_->runAndWait(tr("Writing transforms"),
                          [&] { *error = sentenceOf([&] { writeTransforms(slices, pathOf(folder)); }); });
  if (!error->isEmpty()) return {};
  return tr("Wrote %n transforms to '%1'.", nullptr, static_cast<int>(slices.size()))
      .arg(QDir::toNativeSeparators(folder));
}

QString AppHost::saveSliceTable(const QString& file) {
  const auto result = document_.model(resultId_);
  if (!result) return tr("The result is no longer open.");
  return sentenceOf([&] { writeFileAtomically(pathOf(file), innergs::sliceTable(result->slices)); });
}

std::shared_ptr<const ui::UncertaintyVolume> AppHost::uncertaintyOf(const QString& modelId) const {
  const auto model = document_.model(modelId);
  const auto item = model ? document_.volume(model->uncertaintyId) : nullptr;
  if (!item) return nullptr;
  return std::make_shared<ui::UncertaintyVolume>(
      ui::UncertaintyVolume{item->image, item->ijkToRAS, item->window->firstUpper});
}

void AppHost::cancel() {
  if (isRunning()) runner_->cancel();
}

void AppHost::stopAndKeep() {
  if (isRunning()) runner_->stopAndKeep();
}

bool AppHost::isRunning() const {
  return runner_->isRunning();
}

QString AppHost::addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name, QString* error) {
  std::optional<VolumeItem> item;
  QString sentence;
  const auto copy = [&] {
    const std::string what = "'" + name.toStdString() + "'";
    vtk::checkVoxels(image, what);
    Volume volume{vtk::gridOf(image, ijkToRAS, what), {}};
    volume.voxels = vtk::voxelsOf(image, {{0, 0, 0}, volume.geometry.size}, what);
    item = makeItem(std::move(volume), name);
    item->role = VolumeRole::Made;
    item->saved = false;
  };
  background_->runAndWait(tr("Copying %1").arg(name), [&] { sentence = sentenceOf(copy); });
  if (error) *error = sentence;
  if (!sentence.isEmpty()) {
    Q_EMIT logged(sentence);
    return {};
  }
  return document_.add(std::move(*item));
}

//------------------------------------------------------------------------------
// Segments.

std::function<NamedLabels(const std::stop_token&)>
AppHost::labelsFor(const QString& modelId, const QString& labelsId, const QString& names, QString* error) {
  const auto item = document_.volume(labelsId);
  if (!document_.model(modelId) || !item) {
    *error = tr("The model or the labels are no longer open: choose others.");
    return {};
  }
  if (hasNoGrid(*item)) {
    *error = QString::fromStdString(noGridError(*item).what());
    return {};
  }
  std::vector<SegmentName> known; // of a labelmap made here
  for (const SegmentInfo& segment : item->segments)
    known.push_back(segment.name);
  const QString file = names.isEmpty() && known.empty() ? item->file : names;
  return [volume = item->volume, name = item->name, known, file](const std::stop_token&) {
    NamedLabels given{innergs::labelmapOf(*volume), known};
    if (!file.isEmpty()) given.names = readSegmentNames(pathOf(file));
    if (given.names.empty())
      throw Error(
          ErrorCode::InvalidArgument,
          tr("The labels of '%1' have no names: choose a file with them, e.g. {\"1\": \"liver\", \"2\": "
             "\"spleen\"}.")
              .arg(name)
              .toStdString());
    return given;
  };
}

QString AppHost::setFeatures(const QString& modelId, const std::shared_ptr<const FeatureModel>& features) {
  const auto item = document_.model(modelId);
  if (!item) return tr("The model is no longer open.");
  if (item->dynamic) {
    auto dynamic = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
    dynamic->SetField(item->dynamic->GetField(), features);
    document_.setModel(modelId, vtkSmartPointer<vtkInnerGSModel>::Take(dynamic->NewModelAt(item->time)),
                       dynamic);
    return {};
  }
  auto model = vtkSmartPointer<vtkInnerGSModel>::New();
  model->SetCoreModel(item->model->GetCoreModel(), features);
  document_.setModel(modelId, model);
  return {};
}

void AppHost::previewSegments(const QString&, const MadeSegments& made) {
  Q_EMIT segmentsPreviewed(overlayOf(made));
}

QString AppHost::addSegments(const QString& modelId, const MadeSegments& made, QString* error) {
  if (!document_.model(modelId) || made.segments.empty()) {
    *error = tr("There are no segments to keep: find a structure first.");
    return {};
  }
  std::optional<VolumeItem> item;
  background_->runAndWait(tr("Making %1").arg(app::nameOf(made)),
                          [&] { *error = sentenceOf([&] { item = app::labelmapOf(made); }); });
  if (!item) return {};
  return document_.nameOf(document_.add(std::move(*item)));
}

} // namespace innergs::app
