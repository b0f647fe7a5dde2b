#pragma once
#include "Core/Job/Progress.h"

#include <mutex>
#include <optional>
#include <utility>

namespace innergs::app {

/// The newest progress of a worker until the main thread takes it. A note that it carries is not lost when a
/// newer one follows.
class LatestProgress {
public:
  /// Returns whether take() must be scheduled; false: one for an earlier report is still to come and gives
  /// this one.
  bool put(const Progress& progress) {
    const std::lock_guard lock(mutex_);
    const bool first = !latest_;
    const std::string note = first ? std::string() : latest_->note;
    latest_ = progress;
    if (latest_->note.empty()) latest_->note = note;
    return first;
  }
  /// Nothing after clear().
  std::optional<Progress> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(latest_, std::nullopt);
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    latest_.reset();
  }

private:
  std::mutex mutex_;
  std::optional<Progress> latest_;
};

} // namespace innergs::app
