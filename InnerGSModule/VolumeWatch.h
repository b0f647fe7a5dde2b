#pragma once
#include "ScopedObservers.h"

#include <vtkWeakPointer.h>

#include <QObject>
#include <QString>
#include <QTimer>

class vtkMRMLScene;

/// Tells when names or places of the scene's volumes have changed, not their voxels.
class VolumeWatch : public QObject {
  Q_OBJECT
public:
  explicit VolumeWatch(QObject* parent);

  void setMRMLScene(vtkMRMLScene* scene);
  /// Observes nothing while inactive.
  void setActive(bool active);
  /// Call after volumes came or went; edited() tells of later changes.
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
  QString before_; // text() as last told
};
