#include "Widgets/App/AppHost.h"

#include "IO/FilePath.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"
#include "Widgets/App/VolumeSelector.h"

#include <QDir>
#include <QFileInfo>

#include <algorithm>

namespace innergs::app {

AppHost::AppHost(QObject* parent)
    : Host(parent), background_(new Background(this)), runner_(new Runner(this)),
      estimates_(new Background(this)) {
  qRegisterMetaType<innergs::Progress>();
  qRegisterMetaType<innergs::ui::Report>();
  connect(&document_, &Document::volumesChanged, this, &AppHost::volumesChanged);
  connect(&document_, &Document::modelsChanged, this, &AppHost::modelsChanged);
  connect(runner_, &Runner::progressed, this, &AppHost::progressed);
  connect(runner_, &Runner::previewed, this, &AppHost::previewed);
  for (Background* thread : {background_, estimates_})
    connect(thread, &Background::failed, this, &AppHost::logged);
  const auto ended = [this] { // before anybody is told of it
    ++runs_;
    slow_.clear(); // a fit tells how long others take
  };
  connect(runner_, &Runner::finished, this, ended);
  connect(runner_, &Runner::failed, this, ended);
  connect(runner_, &Runner::cancelled, this, ended);
  connect(runner_, &Runner::finished, this,
          [this](const std::shared_ptr<Outcome>& outcome) { deliver(std::move(*outcome)); });
  connect(runner_, &Runner::failed, this, &AppHost::failed);
  connect(runner_, &Runner::cancelled, this, &AppHost::cancelled);
}

AppHost::~AppHost() {
  disconnect(&document_, nullptr, this, nullptr);
}

bool AppHost::offers(Role role) const {
  return role != Role::Region;
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
  info.description = QString::fromStdString(item->model->GetDescription());
  item->model->GetBounds(info.bounds.data());
  info.window = item->window;
  const GridGeometry& domain = item->model->GetField()->domain;
  if (domain.voxelCount() > 0)
    info.finestSpacing = std::min({domain.spacing[0], domain.spacing[1], domain.spacing[2]});
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
  const QString id = document_.add(std::move(*loaded.model));
  Q_EMIT opened(id, file);
  return id;
}

QString AppHost::saveModel(const QString& id, const QString& file) {
  return save(id, file);
}

QString AppHost::save(const QString& id, const QString& file) {
  // Copies, which share the content: the document's items may be replaced while the thread writes.
  std::optional<VolumeItem> volume;
  std::optional<ModelItem> model;
  if (const auto item = document_.volume(id)) volume = *item;
  if (const auto item = document_.model(id)) model = *item;
  QString sentence;
  if (!volume && !model) sentence = tr("What was to be saved is no longer open.");
  for (const auto& item : document_.volumes())
    if (item->frames.count > 1 && isSameFile(pathOf(item->frames.file), pathOf(file)))
      sentence = tr("'%1' holds all %n frames of what is open as '%2': choose another file.", nullptr,
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
                    (model && modelNow && modelNow->model == model->model);
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

void AppHost::readWantedFrame(const QString& id) {
  const auto item = document_.volume(id);
  const int frame = wantedFrames_.value(id);
  if (!item || frame == item->frames.shown) {
    wantedFrames_.remove(id);
    return;
  }
  const QString file = item->frames.file;
  background_->run(tr("Reading frame %1 of %2").arg(frame + 1).arg(QFileInfo(file).fileName()),
                   [this, id, file, frame] {
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
                       loaded->volume->window = now->window;
                       loaded->volume->role = now->role;
                       const QString name = nameOfFrame(now->name, now->frames.shown, frame);
                       document_.replace(id, std::move(*loaded->volume));
                       document_.rename(id, name);
                       Q_EMIT frameShown(id);
                       readWantedFrame(id);
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

void AppHost::setFolder(const QString& folder) {
  appSettings()->setValue(QStringLiteral("folder"), folder);
}

} // namespace innergs::app
