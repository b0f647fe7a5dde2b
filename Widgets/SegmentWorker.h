#pragma once
#include "Core/Features/FeatureTraining.h"
#include "Text/SegmentFinder.h"

#include <QObject>
#include <QString>
#include <QStringList>

#include <functional>
#include <memory>

namespace innergs::ui {

struct LearningTask {
  SegmentedModel model; // of a dynamic scan at the time of the labels
  /// In the model's own coordinates (LPS, mm). Called on the worker's thread; may throw Error.
  std::function<NamedLabels(const std::stop_token&)> labels;
  bool sparse = false; // slices without any label between labelled ones were not labelled
};

struct FindTask {
  SegmentedModel model;
  std::string query;  // "": only decodes the features, so that the first query is quick
  int candidate = -1; // of the answer, alone; −1: what the answer asks for
  SegmentOptions options;
};

struct FindResult {
  FindTask task;
  QString error; // a sentence; "" when it went well
  SegmentAnswer answer;
  QStringList names; // of its candidates
  MadeSegments made;
};

/// Learns and finds segments on a thread of its own. Of several queries that wait the latest is answered.
/// Signals come on the thread that the object lives in.
class SegmentWorker : public QObject {
  Q_OBJECT
public:
  explicit SegmentWorker(QObject* parent = nullptr);
  ~SegmentWorker() override;

  /// Ends with exactly one of learned(), learningFailed() and learningCancelled().
  void learn(LearningTask task);
  void cancelLearning();
  void find(FindTask task);
  /// Stops what is being found and drops what waits.
  void stopFinding();

Q_SIGNALS:
  void learningProgressed(double fraction);
  void learned(const std::shared_ptr<const innergs::FeatureModel>& features);
  void learningFailed(const QString& sentence);
  void learningCancelled();
  /// The features are being decoded for the first query of a model; 1: done.
  void decoding(double fraction);
  void found(const std::shared_ptr<const innergs::ui::FindResult>& result);

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

} // namespace innergs::ui
