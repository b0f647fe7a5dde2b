#pragma once
#include "Widgets/App/DataItems.h"

#include <QObject>
#include <QString>
#include <QStringList>

#include <memory>
#include <vector>

namespace innergs::app {

/// Everything open in the desktop app. On the main thread only.
class Document : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;

  const std::vector<std::shared_ptr<VolumeItem>>& volumes() const { return volumes_; }
  const std::vector<std::shared_ptr<ModelItem>>& models() const { return models_; }
  /// Null for an unknown ID.
  std::shared_ptr<VolumeItem> volume(const QString& id) const;
  std::shared_ptr<ModelItem> model(const QString& id) const;

  /// Returns the new item's ID. Makes names unique.
  QString add(VolumeItem item);
  QString add(ModelItem item);
  /// Gives the item with an ID new content and keeps its ID and name; false when it is gone.
  bool replace(const QString& id, VolumeItem item);
  bool replace(const QString& id, ModelItem item);
  void rename(const QString& id, const QString& name);
  void remove(const QString& id);
  void setSaved(const QString& id, const QString& file);
  /// Gives a model what it has learned; it is unsaved from now on. dynamic: the model of a dynamic scan, of
  /// which `content` is the state at a time.
  void setModel(const QString& id, const vtkSmartPointer<vtkInnerGSModel>& content,
                const vtkSmartPointer<vtkInnerGSDynamicModel>& dynamic = nullptr);
  void setEllipsoidsShown(const QString& id, bool shown);
  void setEllipsoidsDrawn(const QString& id, std::int64_t count);

  /// IDs.
  QStringList unsaved() const;
  bool hasUnsaved() const { return !unsaved().isEmpty(); }
  /// "" for an unknown ID.
  QString nameOf(const QString& id) const;

Q_SIGNALS:
  void volumesChanged();
  void modelsChanged();

private:
  QString uniqueName(const QString& name) const;
  QString nextId(const QString& kind);
  int count_ = 0;
  std::vector<std::shared_ptr<VolumeItem>> volumes_;
  std::vector<std::shared_ptr<ModelItem>> models_;
};

} // namespace innergs::app
