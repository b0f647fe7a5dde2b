#pragma once
#include "Widgets/App/Document.h"
#include "Widgets/App/Runner.h"
#include "Widgets/ForecastCache.h"
#include "Widgets/Host.h"

#include <QHash>

namespace innergs::app {

class AppMotionHost;
class Background;
struct SegmentOverlay;

/// The desktop app as the panels see it: a document of volumes and models, and one reconstruction at a time.
/// Cancel while the quality of a finished fit is judged ends in finished(), with a warning, not in
/// cancelled(): the result is complete.
class AppHost : public ui::Host {
  Q_OBJECT
public:
  explicit AppHost(QObject* parent = nullptr);
  ~AppHost() override;

  Document& document() { return document_; }
  Background& background() { return *background_; }
  ui::MotionHost* motion() override;
  AppMotionHost& motionHost() { return *motion_; }

  bool offers(Role role) const override;
  ui::Selector* createSelector(Role role, QWidget* parent) override;
  ui::VolumeInfo volumeInfo(const QString& id) const override;

  ui::Estimate estimate(const ui::Request& request) override;
  bool start(const ui::Request& request) override;
  void cancel() override;
  /// cancel() that keeps the state of the fit, to continue from.
  void stopAndKeep();
  bool isRunning() const override;

  bool hasResult() const override { return document_.model(resultId_) != nullptr; }
  vtkTable* sliceTable() const override;
  bool keepsSlicesInFiles() const override { return true; }
  QString createSliceTransforms(const QString& folder, QString* error) override;
  QString saveSliceTable(const QString& file) override;

  ui::ModelInfo modelInfo(const QString& id) const override;
  vtkInnerGSModel* model(const QString& id) const override;
  QString loadModel(const QString& file, QString* error) override;
  QString saveModel(const QString& id, const QString& file) override;
  QString showEllipsoids(const QString& id, bool shown) override;
  std::shared_ptr<const ui::UncertaintyVolume> uncertaintyOf(const QString& modelId) const override;
  QString addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                    QString* error) override;

  bool asksForNames() const override { return true; }
  std::function<NamedLabels(const std::stop_token&)>
  labelsFor(const QString& modelId, const QString& labelsId, const QString& names, QString* error) override;
  QString setFeatures(const QString& modelId, const std::shared_ptr<const FeatureModel>& features) override;
  void previewSegments(const QString& modelId, const MadeSegments& made) override;
  QString addSegments(const QString& modelId, const MadeSegments& made, QString* error) override;

  QString folder() const override;
  QString recoveryFolder() const override;
  void setFolder(const QString& folder) override;

  /// Reads files and DICOM folders (every series) one after another on a thread; each ends with opened(),
  /// which gives the ID of its first item, or with openFailed().
  void open(const QStringList& paths);
  /// Replaces an item by another frame (from 0) of its 4D file; keeps its ID and window. Runs on the thread
  /// and ends with frameShown() or openFailed(); of several waiting frames only the last is read.
  void showFrame(const QString& id, int frame);
  /// Reads a tracked sweep that lacks its calibration again, with one: it keeps its ID and window, and
  /// opened() or openFailed() follow.
  void calibrate(const QString& id, const QString& calibration);
  /// Opens the sample, made from a head (SampleBrain.h), the same way. Remembers a head given here if it can
  /// be used.
  void openSample(const QString& head = {});
  /// Writes an item to a file of any kind, by its extension; returns "" or a sentence. Keeps the windows
  /// painting meanwhile. An item that was replaced meanwhile, or was written to a .ply file, stays unsaved.
  QString save(const QString& id, const QString& file);

Q_SIGNALS:
  void opened(const QString& id, const QString& path);
  void openFailed(const QString& path, const QString& sentence);
  void frameShown(const QString& id);
  /// To be shown over the volume in the views; null: nothing.
  void segmentsPreviewed(const std::shared_ptr<const innergs::app::SegmentOverlay>& overlay);

private:
  /// A snapshot of what is needed; throws Error when something is wrong with the request.
  ReconstructionTask taskFor(const ui::Request& request) const;
  void deliver(Outcome outcome);
  void readWantedFrame(const QString& id);
  /// Puts another reading of an item's file in its place, with its ID, window and role;
  /// name: not a reference to `before`'s.
  void replaceVolume(const VolumeItem& before, VolumeItem item, const QString& name);

  Document document_;
  Background* background_; // files
  Runner* runner_;
  AppMotionHost* motion_;
  ui::Request request_;              // of the reconstruction that runs
  QString resultId_;                 // the model of the last one
  QHash<QString, int> wantedFrames_; // by item, while one is read
  Background* estimates_;
  ui::ForecastCache forecasts_;
};

} // namespace innergs::app
