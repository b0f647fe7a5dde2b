#include "CLI/ProgressDisplay.h"

#include "CLI/Platform.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace innergs::cli {
namespace {

constexpr auto barInterval = std::chrono::milliseconds(100);
constexpr auto lineInterval = std::chrono::seconds(5);
constexpr int barWidth = 16;
constexpr int lineWidth = 79; // fits an 80-column terminal

std::string state(const Progress& progress) {
  std::string text;
  if (progress.iterations > 0) text += fmt::format("  {}/{}", progress.iteration, progress.iterations);
  if (!resultIsComplete(progress.phase)) { // those belong to another fit
    if (progress.trainingPsnr > 0 && std::isfinite(progress.trainingPsnr))
      text += fmt::format("  fit {:.2f} dB", progress.trainingPsnr);
    else if (progress.loss > 0)
      text += fmt::format("  loss {:.2e}", progress.loss);
  }
  if (progress.remaining >= 0.5 && progress.remaining < 1e6) {
    const auto seconds = std::llround(progress.remaining);
    text += fmt::format("  {}:{:02} left", seconds / 60, seconds % 60);
  }
  return text;
}

} // namespace

std::string durationText(double seconds) {
  const auto total = static_cast<long long>(std::ceil(std::max(0.0, seconds)));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total % 3600 / 60);
}

ProgressDisplay::ProgressDisplay(bool quiet)
    : quiet_(quiet), terminal_(errorStreamIsTerminal()), phaseStart_(Clock::now()) {}

ProgressDisplay::~ProgressDisplay() {
  clearBar();
}

void ProgressDisplay::show(const Progress& progress) {
  if (progress.phase == Phase::Done) return finish();
  const auto now = Clock::now();
  const std::string name = phaseName(progress.phase);
  const bool newPhase = phases_.back().first != name;
  if (newPhase) {
    endPhase();
    phases_.emplace_back(name, 0);
  }
  if (quiet_) return;
  if (!progress.note.empty()) say(progress.note);
  if (!newPhase &&
      now - lastShown_ < (terminal_ ? Clock::duration(barInterval) : Clock::duration(lineInterval)))
    return;
  lastShown_ = now;
  const double fraction = std::clamp(progress.fraction, 0.0, 1.0);
  if (!terminal_) {
    if (progress.phase == Phase::Preparing) return; // an error in that phase gets its own single line
    fmt::print(stderr, "{} {:.0f} %{}\n", name, 100 * fraction, state(progress));
  } else {
    const int filled = static_cast<int>(fraction * barWidth);
    const std::string bar = std::string(filled, '#') + std::string(barWidth - filled, '-');
    std::string line = fmt::format("{:<18}[{}] {:3.0f} %{}", name, bar, 100 * fraction, state(progress));
    fmt::print(stderr, "\r{:<{}}", line.substr(0, lineWidth), lineWidth);
    barShown_ = true;
  }
  std::fflush(stderr);
}

void ProgressDisplay::finish() {
  if (phases_.back().second == 0) endPhase();
  clearBar();
}

void ProgressDisplay::endPhase() {
  const auto now = Clock::now();
  phases_.back().second = std::chrono::duration<double>(now - phaseStart_).count();
  phaseStart_ = now;
}

void ProgressDisplay::say(const std::string& line) {
  if (quiet_) return;
  clearBar();
  fmt::print(stderr, "{}\n", line);
}

void ProgressDisplay::clearBar() {
  if (!barShown_) return;
  fmt::print(stderr, "\r{:<{}}\r", "", lineWidth);
  std::fflush(stderr);
  barShown_ = false;
}

} // namespace innergs::cli
