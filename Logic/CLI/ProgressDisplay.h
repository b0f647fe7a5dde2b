#pragma once
#include "Core/Job/Progress.h"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace innergs::cli {

/// Shows a job's progress on stderr: a bar on a terminal, otherwise a line every few seconds, nothing if
/// quiet. Also measures the duration of each phase.
class ProgressDisplay {
public:
  explicit ProgressDisplay(bool quiet);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void show(const Progress& progress);
  /// Ends the last phase and clears the bar.
  void finish();
  /// Prints a line to stderr, above the bar if there is one; nothing if quiet.
  void say(const std::string& line);

  /// Phase names with their seconds, in order.
  const std::vector<std::pair<std::string, double>>& phases() const { return phases_; }

private:
  using Clock = std::chrono::steady_clock;
  void clearBar();
  void endPhase();

  bool quiet_, terminal_, barShown_ = false;
  Clock::time_point phaseStart_, lastShown_;
  std::vector<std::pair<std::string, double>> phases_{
      {"Reading", 0}}; // until the job reports its first phase
};

/// "12 s", "3 min 05 s", "1 h 02 min".
std::string durationText(double seconds);

} // namespace innergs::cli
