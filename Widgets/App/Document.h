#pragma once
#include "Core/Image/Volume.h"
#include "vtkInnerGSModel.h"

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkSmartPointer.h>

#include <QObject>
#include <QString>
#include <QStringList>

#include <array>
#include <memory>
#include <vector>

namespace innergs::app {

/// The intensities shown black and white. An input and its results share one, so that they can be compared.
struct Window {
  double lower = 0, upper = 1;
  double firstLower = 0, firstUpper = 1; // what "reset" goes back to
};

/// The images of a 4D file, of which an item is one.
struct Frames {
  QString file; // that holds them; "" no such file
  int count = 1;
  int shown = 0;      // from 0
  double seconds = 0; // from one to the next; 0: unknown
};

/// What a volume is: only a scan is one to begin a reconstruction with.
enum class VolumeRole {
  Scan,  // opened as such
  Truth, // what the sample's scan was made from, to compare with
  Made   // here: a result or a plane, saved or not
};

/// A scalar volume of the document. Its voxels never change, so threads may read them.
struct VolumeItem {
  QString id, name, file; // file "": in none yet
  VolumeRole role = VolumeRole::Scan;
  QString note; // what was done to open it, sentences; may be ""
  Frames frames;
  std::shared_ptr<const Volume> volume;
  vtkSmartPointer<vtkImageData> image;    // the same voxels; origin 0, spacing 1
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // mm
  double thickness = 0;                   // mm, as the file says; 0: the distance between slices
  int sliceAxis = 2;                      // counts the slices
  std::array<double, 2> range{0, 0};      // of the finite voxels
  std::shared_ptr<Window> window;
  bool saved = true;
};

/// A model of the document.
struct ModelItem {
  QString id, name, file;
  QString origin; // the scans' names, or the file
  vtkSmartPointer<vtkInnerGSModel> model;
  std::array<double, 2> window{0, 1}; // intensities worth showing
  bool saved = true, ellipsoidsShown = false;
  std::int64_t ellipsoids = 0; // that the 3D view draws
};

/// An item (without ID) for a volume: image, range, window and slice axis. Looks at every voxel: for worker
/// threads. Throws Error(Geometry | NoData).
VolumeItem makeItem(Volume volume, const QString& name, const QString& file = {}, double thickness = 0,
                    int sliceAxis = -1);
ModelItem makeItem(std::shared_ptr<const Checkpoint> model, const QString& name, const QString& file = {});

/// "axial", "coronal", "sagittal" or "oblique": how the slices along an axis lie.
QString orientationOf(const GridGeometry& geometry, int sliceAxis);

/// What is open in the desktop app. On the main thread only.
class Document : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;

  const std::vector<std::shared_ptr<VolumeItem>>& volumes() const { return volumes_; }
  const std::vector<std::shared_ptr<ModelItem>>& models() const { return models_; }
  /// Null for an unknown ID.
  std::shared_ptr<VolumeItem> volume(const QString& id) const;
  std::shared_ptr<ModelItem> model(const QString& id) const;

  /// The ID it got. Names are made unique.
  QString add(VolumeItem item);
  QString add(ModelItem item);
  /// Gives the item with an ID new content and keeps its ID and name; false when it is gone.
  bool replace(const QString& id, VolumeItem item);
  bool replace(const QString& id, ModelItem item);
  void rename(const QString& id, const QString& name);
  void remove(const QString& id);
  void setSaved(const QString& id, const QString& file);
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
