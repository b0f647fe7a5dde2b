#include "Widgets/SegmentWorker.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Base/ThreadPriority.h"
#include "Core/Device/FeatureDeviceChoice.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

namespace innergs::ui {

struct SegmentWorker::Work {
  explicit Work(SegmentWorker* owner) : owner(owner) {}
  ~Work() {
    {
      std::lock_guard lock(mutex);
      quit = true;
      learningStop.request_stop();
      findingStop.request_stop();
    }
    toDo.notify_all();
    if (thread.joinable()) thread.join();
  }

  SegmentWorker* owner;
  std::mutex mutex; // of what follows, until the thread's own
  std::condition_variable toDo;
  std::optional<LearningTask> learning;
  std::optional<FindTask> query;
  std::stop_source learningStop, findingStop;
  bool quit = false;
  std::thread thread;

  // The thread's own.
  SegmentedModel model;
  std::optional<SegmentFinder> finder;

  template <class Signal, class... Arguments>
  void tell(Signal signal, Arguments... arguments) {
    QMetaObject::invokeMethod(
        owner,
        [this, signal, arguments...] {
          Q_EMIT(owner->*signal)
          (arguments...);
        },
        Qt::QueuedConnection);
  }

  /// "" where there is a thread.
  QString start() {
    if (thread.joinable()) return {};
    try {
      thread = std::thread([this] { run(); });
      return {};
    } catch (...) {
      return QString::fromStdString(failureOf().sentence);
    }
  }

  void run() {
    lowerThreadPriority(); // views have priority
    for (;;) {
      std::optional<LearningTask> nextLearning;
      std::optional<FindTask> nextQuery;
      std::stop_token stop;
      {
        std::unique_lock lock(mutex);
        toDo.wait(lock, [&] { return quit || learning || query; });
        if (quit) return;
        if (learning) {
          nextLearning.swap(learning);
          stop = learningStop.get_token();
        } else {
          nextQuery.swap(query);
          stop = findingStop.get_token();
        }
      }
      if (nextLearning)
        teach(*nextLearning, stop);
      else
        answer(std::move(*nextQuery), stop);
    }
  }

  void teach(const LearningTask& task, const std::stop_token& stop) {
    try {
      NamedLabels given = task.labels(stop);
      if (task.sparse) given.labels = withSparseSlices(given.labels);
      FeatureTraining training;
      training.stop = stop;
      training.devices = std::make_shared<FeatureDeviceChoice>("auto");
      training.progress = [this](double fraction) { tell(&SegmentWorker::learningProgressed, fraction); };
      tell(&SegmentWorker::learned,
           std::make_shared<const FeatureModel>(trainFrom(task.model, std::move(given), training)));
    } catch (...) {
      const Failure failure = failureOf();
      if (failure.code == ErrorCode::Cancelled)
        tell(&SegmentWorker::learningCancelled);
      else
        tell(&SegmentWorker::learningFailed, QString::fromStdString(failure.sentence));
    }
  }

  void answer(FindTask task, const std::stop_token& stop) {
    const auto result = std::make_shared<FindResult>();
    try {
      if (!task.query.empty()) interpret(Lexicon::standard(), task.query); // rejects invalid queries first
      if (!finder || model != task.model) {
        finder.reset();
        finder.emplace(task.model);
        model = task.model;
      }
      FeatureQueryOptions options;
      options.stop = stop;
      options.progress = [this](double fraction) { tell(&SegmentWorker::decoding, fraction); };
      finder->encode(finder->region(), options);
      if (!task.query.empty()) {
        result->answer = finder->find(task.query);
        for (const SegmentCandidate& candidate : result->answer.candidates)
          result->names << QString::fromStdString(finder->nameOf(candidate));
        const bool alone =
            task.candidate >= 0 && task.candidate < static_cast<int>(result->answer.candidates.size());
        result->made =
            finder->make(alone ? std::vector<RequestedSegment>{finder->requested(
                                     result->answer.candidates[static_cast<std::size_t>(task.candidate)])}
                               : finder->requested(task.query, result->answer),
                         task.options, stop);
      }
    } catch (...) {
      const Failure failure = failureOf();
      if (failure.code == ErrorCode::Cancelled) return;
      result->error = QString::fromStdString(failure.sentence);
    }
    result->task = std::move(task);
    tell(&SegmentWorker::found, std::shared_ptr<const FindResult>(result));
  }
};

SegmentWorker::SegmentWorker(QObject* parent) : QObject(parent), work_(std::make_unique<Work>(this)) {}
SegmentWorker::~SegmentWorker() = default;

void SegmentWorker::learn(LearningTask task) {
  if (const QString problem = work_->start(); !problem.isEmpty()) {
    work_->tell(&SegmentWorker::learningFailed, problem);
    return;
  }
  {
    std::lock_guard lock(work_->mutex);
    work_->learningStop = std::stop_source();
    work_->learning = std::move(task);
  }
  work_->toDo.notify_all();
}

void SegmentWorker::cancelLearning() {
  std::lock_guard lock(work_->mutex);
  work_->learningStop.request_stop();
}

void SegmentWorker::find(FindTask task) {
  if (const QString problem = work_->start(); !problem.isEmpty()) {
    const auto result = std::make_shared<FindResult>();
    result->error = problem;
    result->task = std::move(task);
    work_->tell(&SegmentWorker::found, std::shared_ptr<const FindResult>(result));
    return;
  }
  {
    std::lock_guard lock(work_->mutex);
    work_->query = std::move(task);
  }
  work_->toDo.notify_all();
}

void SegmentWorker::stopFinding() {
  std::lock_guard lock(work_->mutex);
  work_->query.reset();
  work_->findingStop.request_stop();
  work_->findingStop = std::stop_source();
}

} // namespace innergs::ui
