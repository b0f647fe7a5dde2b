#pragma once
#include "ScopedObservers.h"

#include <vtkWeakPointer.h>

#include <QObject>
#include <QString>
#include <QTimer>

class vtkMRMLScene;

/// Emits edited() when the name, place or size of a volume in the scene has changed, not for its voxels.
class VolumeObserver : public QObject {
  Q_OBJECT
public:
  explicit VolumeObserver(QObject* parent);

  void setMRMLScene(vtkMRMLScene* scene);
  /// Observes nothing while inactive.
  void setActive(bool active);
  /// Call after volumes were added or removed; edited() then tells of later changes only.
  void update();

Q_SIGNALS:
  void edited();

private:
  void observe();
  void onVolume(vtkObject* caller, unsigned long event, void* data);
  QString text() const;

  vtkWeakPointer<vtkMRMLScene> scene_;
  bool active_ = false;
  ScopedObservers observers_;
  QTimer timer_;   // one signal for many edits
  QString before_; // text() at the last signal
};
