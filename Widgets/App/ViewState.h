#pragma once
#include "Core/Image/Linear.h"
#include "Widgets/App/Document.h"
#include "Widgets/App/RenderTurns.h"

namespace innergs::app {

struct SegmentOverlay;

/// What all views share: the shown volume and the crosshair's position.
class ViewState : public QObject {
  Q_OBJECT
public:
  explicit ViewState(Document* document, QObject* parent = nullptr);

  Document* document() const { return document_; }
  /// Null when nothing is shown.
  std::shared_ptr<VolumeItem> volume() const { return document_->volume(volumeId_); }
  QString volumeId() const { return volumeId_; }
  void setVolumeId(const QString& id);
  /// The next (1) or previous (−1) volume of the document; the crosshair and the views stay.
  void step(int by);

  /// RAS, mm.
  Vec3 crosshair() const { return crosshair_; }
  void setCrosshair(const Vec3& ras);

  /// Of the shown volume; shared with its results.
  void setWindow(double lower, double upper);
  void resetWindow();

  /// RAS box of the shown volume, to voxel edges: xmin, xmax, ymin, ...; all 0 when there is none.
  std::array<double, 6> bounds() const;
  /// Trilinear value of the shown volume; false outside.
  bool valueAt(const Vec3& ras, double& value) const;
  /// mm between the slices of the shown volume along a RAS axis.
  double stepAlong(int axis) const;

  /// "R 12.3  A 4.5  I 6.7 mm: 134" for people.
  QString describe(const Vec3& ras) const;

  /// Segments to be shown over the volume; null: none.
  std::shared_ptr<const SegmentOverlay> overlay() const { return overlay_; }
  void setOverlay(std::shared_ptr<const SegmentOverlay> overlay);

  /// In which the views draw themselves.
  RenderTurns& turns() { return turns_; }

Q_SIGNALS:
  void volumeChanged(); // another one, or its content
  void crosshairChanged();
  void placeChanged(); // the volume lies elsewhere: the crosshair was moved into it, views go there
  void windowChanged();
  void overlayChanged();

private:
  void refresh();
  void show(const std::shared_ptr<VolumeItem>& item);
  Document* document_;
  QString volumeId_;
  std::shared_ptr<const Volume> shown_; // that the views know of
  Vec3 crosshair_{0, 0, 0};
  std::shared_ptr<const SegmentOverlay> overlay_;
  RenderTurns turns_;
};

} // namespace innergs::app
