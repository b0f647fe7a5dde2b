#include "IO/DicomTimes.h"

#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace innergs {
namespace {

/// From DICOM's HHMMSS.FFFFFF.
std::optional<double> secondsAfterMidnight(std::string text) {
  while (!text.empty() && text.back() == ' ') // DICOM values have an even number of characters
    text.pop_back();
  const auto time = wholeTextNumber(text);
  if (!time || text.size() < 6 || !(*time >= 0 && *time < 240000)) return std::nullopt;
  const double hours = std::floor(*time / 10000), minutes = std::floor(*time / 100) - 100 * hours;
  return 3600 * hours + 60 * minutes + std::fmod(*time, 100);
}

std::optional<double> secondsAfterTrigger(const std::string& text) {
  auto time = leadingNumber(text);
  if (time) *time /= 1000; // ms
  return time;
}

/// Empty where one does not say.
template <class Parser>
std::vector<double> timesOf(std::span<const std::string> texts, const Parser& parse) {
  std::vector<double> times;
  for (const std::string& text : texts) {
    const std::optional<double> time = parse(text);
    if (!time || !std::isfinite(*time)) return {};
    times.push_back(*time);
  }
  return times;
}

} // namespace

std::vector<double> dicomSliceTimes(std::span<const std::string> acquired,
                                    std::span<const std::string> triggered) {
  for (const bool trigger : {false, true}) {
    std::vector<double> times =
        trigger ? timesOf(triggered, secondsAfterTrigger) : timesOf(acquired, secondsAfterMidnight);
    if (times.empty()) continue;
    const auto [first, last] = std::minmax_element(times.begin(), times.end());
    if (*first == *last) continue;
    if (constexpr double day = 86400; *last - *first > day / 2) // past midnight
      for (double& time : times)
        if (time < day / 2) time += day;
    return times;
  }
  return {};
}

} // namespace innergs
