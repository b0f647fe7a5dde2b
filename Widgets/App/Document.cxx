#include "Widgets/App/Document.h"

#include <algorithm>

namespace innergs::app {
namespace {

template <class Item>
std::shared_ptr<Item> find(const std::vector<std::shared_ptr<Item>>& items, const QString& id) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item->id == id; });
  return found == items.end() ? nullptr : *found;
}

template <class Item>
bool put(const std::shared_ptr<Item>& old, Item& item) {
  if (!old) return false;
  item.id = old->id;
  item.name = old->name;
  *old = std::move(item);
  return true;
}

} // namespace

std::shared_ptr<VolumeItem> Document::volume(const QString& id) const {
  return find(volumes_, id);
}

std::shared_ptr<ModelItem> Document::model(const QString& id) const {
  return find(models_, id);
}

QString Document::uniqueName(const QString& name) const {
  const auto taken = [&](const QString& candidate) {
    const auto same = [&](const auto& item) { return item->name == candidate; };
    return std::any_of(volumes_.begin(), volumes_.end(), same) ||
           std::any_of(models_.begin(), models_.end(), same);
  };
  QString candidate = name;
  for (int n = 2; taken(candidate); ++n)
    candidate = QStringLiteral("%1 (%2)").arg(name).arg(n);
  return candidate;
}

QString Document::nextId(const QString& kind) {
  return kind + QString::number(++count_);
}

QString Document::add(VolumeItem item) {
  item.id = nextId(QStringLiteral("volume"));
  item.name = uniqueName(item.name);
  QString id = item.id;
  volumes_.push_back(std::make_shared<VolumeItem>(std::move(item)));
  Q_EMIT volumesChanged();
  return id;
}

QString Document::add(ModelItem item) {
  item.id = nextId(QStringLiteral("model"));
  item.name = uniqueName(item.name);
  QString id = item.id;
  models_.push_back(std::make_shared<ModelItem>(std::move(item)));
  Q_EMIT modelsChanged();
  return id;
}

bool Document::replace(const QString& id, VolumeItem item) {
  if (!put(volume(id), item)) return false;
  Q_EMIT volumesChanged();
  return true;
}

bool Document::replace(const QString& id, ModelItem item) {
  if (!put(model(id), item)) return false;
  Q_EMIT modelsChanged();
  return true;
}

void Document::rename(const QString& id, const QString& name) {
  const QString trimmed = name.trimmed();
  if (trimmed.isEmpty()) return;
  if (const auto item = volume(id); item && item->name != trimmed) {
    item->name = uniqueName(trimmed);
    Q_EMIT volumesChanged();
  } else if (const auto other = model(id); other && other->name != trimmed) {
    other->name = uniqueName(trimmed);
    Q_EMIT modelsChanged();
  }
}

void Document::remove(const QString& id) {
  const auto same = [&](const auto& item) { return item->id == id; };
  if (std::erase_if(volumes_, same) > 0) Q_EMIT volumesChanged();
  if (std::erase_if(models_, same) > 0) Q_EMIT modelsChanged();
}

void Document::setSaved(const QString& id, const QString& file) {
  if (const auto item = volume(id)) {
    item->file = file;
    item->saved = true;
    Q_EMIT volumesChanged();
  } else if (const auto other = model(id)) {
    other->file = file;
    other->saved = true;
    Q_EMIT modelsChanged();
  }
}

void Document::setModel(const QString& id, const vtkSmartPointer<vtkInnerGSModel>& content,
                        const vtkSmartPointer<vtkInnerGSDynamicModel>& dynamic) {
  const auto item = model(id);
  if (!item) return;
  item->model = content;
  item->dynamic = dynamic;
  item->saved = false;
  Q_EMIT modelsChanged();
}

void Document::setEllipsoidsShown(const QString& id, bool shown) {
  const auto item = model(id);
  if (!item || item->ellipsoidsShown == shown) return;
  item->ellipsoidsShown = shown;
  item->ellipsoids = 0;
  Q_EMIT modelsChanged();
}

void Document::setEllipsoidsDrawn(const QString& id, std::int64_t count) {
  const auto item = model(id);
  if (!item || item->ellipsoids == count) return;
  item->ellipsoids = count;
  Q_EMIT modelsChanged();
}

QStringList Document::unsaved() const {
  QStringList ids;
  const auto add = [&](const auto& items) {
    for (const auto& item : items)
      if (!item->saved) ids << item->id;
  };
  add(volumes_);
  add(models_);
  return ids;
}

QString Document::nameOf(const QString& id) const {
  if (const auto item = volume(id)) return item->name;
  const auto item = model(id);
  return item ? item->name : QString();
}

} // namespace innergs::app
