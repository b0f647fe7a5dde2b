#include "Widgets/App/AppHost.h"

#include "Core/Base/Error.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SegmentItems.h"

#include <QFileInfo>

// The app's segments by what they are called.

namespace innergs::app {

std::function<NamedLabels(const std::stop_token&)>
AppHost::labelsFor(const QString& modelId, const QString& labelsId, const QString& names, QString* error) {
  const auto item = document_.volume(labelsId);
  if (!document_.model(modelId) || !item) {
    *error = tr("The model or the labels are no longer open: choose others.");
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
  if (item->moving) {
    auto moving = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
    moving->SetField(item->moving->GetField(), features);
    document_.setModel(modelId, vtkSmartPointer<vtkInnerGSModel>::Take(moving->NewModelAt(item->time)),
                       moving);
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
