#pragma once
#include "Evaluation/JudgedReconstruction.h"
#include "Widgets/App/DataItems.h"
#include "Widgets/App/LatestProgress.h"
#include "Widgets/Request.h"

#include <QObject>

#include <atomic>
#include <optional>
#include <stop_token>
#include <thread>

namespace innergs::app {

/// What a reconstruction works on, independent of the document: the request, and volumes that never change.
struct ReconstructionTask {
  ui::Request request;
  std::vector<VolumeItem> inputs;      // in the request's order, at least one
  std::vector<VolumeItem> masks;       // none, one for all inputs, or one for each
  std::optional<VolumeItem> reference; // there if the output takes its grid
  QString recoveryFolder;              // where stopAndKeep() writes
  std::array<double, 2> window{0, 1};  // of the first input: the views change theirs meanwhile
};

/// The engine's input; without voxels (to estimate) only the masks' are copied. Throws Error.
ReconstructionInput makeInput(const ReconstructionTask& task, bool voxels);
/// Protocol H keeps every n-th slice to judge the quality; none: not asked for.
std::optional<int> keepEvery(const ReconstructionTask& task);

/// The result, on its way to the document.
struct Outcome {
  VolumeItem volume;
  std::optional<VolumeItem> uncertainty, measured; // standard deviations; 1 where some slice measured
  ModelItem model;
  ui::Report report; // without IDs
};

/// Runs reconstructions, one at a time, on a thread of its own.
class Runner : public QObject {
  Q_OBJECT
public:
  explicit Runner(QObject* parent = nullptr);
  /// Stops what runs, waits for it (≤ 200 ms and the writing) and keeps its state.
  ~Runner() override;

  /// Ends with failed() where no thread can be started.
  void start(ReconstructionTask task);
  /// Returns at once. A fit that is complete, its quality perhaps still being judged, still ends with
  /// finished().
  void cancel();
  /// cancel() that keeps the state of the fit in the task's recovery folder; failed() if it cannot.
  void stopAndKeep();
  bool isRunning() const { return running_; }

Q_SIGNALS:
  // On the main thread. Every start ends with one of the last three.
  void progressed(const innergs::Progress& progress);
  void previewed(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  void finished(const std::shared_ptr<innergs::app::Outcome>& outcome);
  void failed(const QString& sentence);
  void cancelled();

private:
  void work(const ReconstructionTask& task, const std::stop_token& stop);
  std::shared_ptr<Outcome> reconstruct(const ReconstructionTask& task, const std::stop_token& stop);
  void post(const Progress& progress);
  void post(const Volume& preview);
  template <class Call>
  void deliver(Call call);

  bool running_ = false; // main thread
  std::atomic<bool> keep_{false};
  LatestProgress latest_;
  std::jthread thread_;
};

} // namespace innergs::app
