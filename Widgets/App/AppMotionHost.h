#pragma once
#include "Evaluation/JudgedSeries.h"
#include "Widgets/App/DataItems.h"
#include "Widgets/App/LatestProgress.h"
#include "Widgets/MotionHost.h"

#include <QHash>

#include <optional>
#include <thread>

namespace innergs::app {

class AppHost;
class Background;

/// Dynamic scans in the desktop app: 4D files of the document. A model of one is shown at a time as a volume
/// of the document beside it.
class AppMotionHost : public ui::MotionHost {
  Q_OBJECT
public:
  explicit AppMotionHost(AppHost* host);
  /// Stops what runs, waits for it (≤ 200 ms and the writing) and keeps its state.
  ~AppMotionHost() override;

  ui::SeriesInfo seriesInfo(const QString& id) const override;
  bool start(const ui::MotionRequest& request) override;
  void cancel() override;
  bool isRunning() const override { return running_; }
  ui::MotionInfo motionInfo(const QString& modelId) const override;
  void setTime(const QString& modelId, double seconds) override;
  ui::MotionInfo previewInfo() const override;
  void setPreviewTime(double seconds) override;
  bool savesFrames() const override { return true; }
  QString saveFrames(const QString& modelId, double rate, const QString& file) override;

Q_SIGNALS:
  /// The volume that shows a model at its time has new content.
  void frameShown(const QString& volumeId);

private:
  struct Outcome {
    ModelItem model;
    ui::MotionReport report;
  };
  void work(const ui::MotionRequest& request, const VolumeItem& scan, const std::stop_token& stop);
  void post(const Progress& progress);
  void keep(const ui::MotionRequest& request, const VolumeItem& scan, const DynamicResult& result);
  void deliver(Outcome& outcome);
  void showWanted();
  void receivePreview(const std::shared_ptr<const DynamicField>& field);
  void dropPreview();

  AppHost* host_;
  bool running_ = false;
  LatestProgress latest_;
  std::jthread thread_;

  struct Wanted {
    QString modelId; // "": the preview
    double time;     // s
  };
  std::optional<Wanted> wanted_; // to be shown next
  QHash<QString, double> asked_; // s, by model: what was asked for last, whatever is shown yet
  bool showing_ = false;
  struct Shown {
    QString volumeId;
    std::shared_ptr<Window> window; // of the scan
    QString scan;                   // its name
  };
  QHash<QString, Shown> shown_; // by model

  vtkSmartPointer<vtkInnerGSDynamicModel> preview_; // null: none
  Shown previewShown_;
  double previewTime_ = 0; // s
  int run_ = 0;            // counts the fits
  Background* frames_;
};

} // namespace innergs::app
