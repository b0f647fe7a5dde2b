#pragma once
#include "Core/Job/Progress.h"
#include "Core/Settings/Settings.h"
#include "Widgets/Request.h"

#include <QObject>

class vtkInnerGSDynamicModel;

namespace innergs::ui {

/// A dynamic scan that can be reconstructed.
struct SeriesInfo {
  QString name;                    // "" for an unknown ID
  int frames = 0;                  // 0: unknown before it is read
  std::array<int, 3> dimensions{}; // voxels along I, J, K
  bool timed = true;               // the scan says when its frames were acquired
  double first = 0, last = 0;      // s, of the frames; both 0: not known before it is read
  QString problem;                 // why it cannot be reconstructed, a sentence; "": it can
};

/// What a reconstruction of a dynamic scan is asked for.
struct MotionRequest {
  QString seriesId;
  double interval = 0;         // s from one frame to the next; 0: as the scan says
  Settings settings;           // only those of dynamic scans count
  double rate = 0;             // frames per second of the frames to make; 0: the scan's own times
  bool evaluateQuality = true; // on frames that a second fit does not see
  QString sliceTimesFile; // of readSliceTiming(): when a frame's slices were acquired; "": as the scan says
  QString resumeFile;     // a model file to resume; "": none
};

/// What a successful reconstruction reports.
struct MotionReport {
  QString modelId;
  QString choice;              // why this kind, a sentence; "" where the user chose it
  QStringList warnings;        // sentences
  QVector<QualityRow> quality; // on held-out frames; empty: not judged
  QString samples;             // which frames these are
  std::int64_t gaussians = 0;
  double seconds = 0;
};

/// A model of a dynamic scan.
struct MotionInfo {
  bool known = false;
  double first = 0, last = 0, now = 0; // s
  QString kind;                        // "motion", "intensity", "network"
};

/// The info of a model at `now` (s); not known for null and for an empty model.
MotionInfo motionInfoOf(vtkInnerGSDynamicModel* model, double now);

/// What the panel of dynamic scans needs from the program besides the Host; on the main thread only. One
/// reconstruction at a time: every start() that returns true ends with exactly one of finished, failed and
/// cancelled.
class MotionHost : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;

  virtual SeriesInfo seriesInfo(const QString& id) const = 0;
  /// False, after failed(sentence), when it is refused.
  virtual bool start(const MotionRequest& request) = 0;
  /// Returns at once. Host::recoveryFolder() keeps the state once the frames are refined together, as when
  /// anything else stops it.
  virtual void cancel() = 0;
  virtual bool isRunning() const = 0;

  /// Not known for models that do not move.
  virtual MotionInfo motionInfo(const QString& modelId) const = 0;
  /// Shows the model at a time (s), as a frame in the slice views and wherever else it is seen. Returns at
  /// once; of several waiting times only the last is shown.
  virtual void setTime(const QString& modelId, double seconds) = 0;
  /// While one is fitted: the model so far; not known before previewed().
  virtual MotionInfo previewInfo() const { return {}; }
  /// setTime() for it.
  virtual void setPreviewTime(double seconds) { Q_UNUSED(seconds) }
  /// Writes frames (rate as in the request) as one 4D file; "" or a sentence. Only where the program has no
  /// other way: savesFrames().
  virtual bool savesFrames() const = 0;
  virtual QString saveFrames(const QString& modelId, double rate, const QString& file) = 0;

Q_SIGNALS:
  void started();
  void progressed(const innergs::Progress& progress);
  void previewed(); // previewInfo() is newer
  void finished(const innergs::ui::MotionReport& report);
  void failed(const QString& sentence);
  void cancelled();
  /// The time was changed elsewhere, by the sequence browser.
  void timeChanged(const QString& modelId, double seconds);
};

} // namespace innergs::ui

Q_DECLARE_METATYPE(innergs::ui::MotionReport)
