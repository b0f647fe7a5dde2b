#include "IO/TimeSeriesIO.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/FilePath.h"
#include "IO/ImageReading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

namespace fs = std::filesystem;

namespace innergs {
namespace {

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

void checkCount(const std::vector<double>& times, std::size_t frames, const std::string& what) {
  if (times.size() != frames)
    throw Error(ErrorCode::InvalidArgument, what + " has " + std::to_string(frames) + " frames, and " +
                                                std::to_string(times.size()) +
                                                " times are given: give one per frame.");
}

std::vector<double> even(double first, double interval, std::size_t count) {
  std::vector<double> times;
  for (std::size_t f = 0; f < count; ++f)
    times.push_back(first + interval * static_cast<double>(f));
  return times;
}

/// The requested times; empty: none requested.
std::vector<double> givenTimes(const TimeSeriesOptions& options, std::size_t frames,
                               const std::string& what) {
  if (options.interval && !(std::isfinite(*options.interval) && *options.interval > 0))
    throw Error(ErrorCode::InvalidArgument, "The time between frames must be above 0 s.");
  if (!options.times.empty()) {
    checkCount(options.times, frames, what);
    return options.times;
  }
  return options.interval ? even(0, *options.interval, frames) : std::vector<double>{};
}

/// When the slices of a frame were acquired, as a chosen file, the sidecar or else the header says.
SliceTiming sliceTimingOf(const LoadedFrames& loaded, const BidsTimes& bids, const fs::path& sidecar,
                          const fs::path& chosen) {
  const int axis = loaded.sliceAxis >= 0 ? loaded.sliceAxis : 2;
  if (!chosen.empty()) return readSliceTiming(chosen, loaded.geometry, axis);
  if (auto timing = sliceTimingFrom(bids, axis, loaded.geometry, quoted(sidecar))) return *timing;
  const auto& times = loaded.sliceSeconds;
  const bool atOnce = std::all_of(times.begin(), times.end(), [&](double t) { return t == times.front(); });
  return {axis, atOnce ? std::vector<double>() : times};
}

std::vector<double> timesOf(const LoadedFrames& loaded, const BidsTimes& bids, const fs::path& path,
                            const TimeSeriesOptions& options) {
  const std::string what = quoted(path);
  const std::size_t frames = loaded.frames.size();
  if (auto given = givenTimes(options, frames, what); !given.empty()) return given;
  if (!bids.frames.empty()) {
    checkCount(bids.frames, frames, what);
    return bids.frames;
  }
  if (!loaded.indexValues.empty()) {
    checkCount(loaded.indexValues, frames, what);
    const std::string& unit = loaded.indexUnit;
    const double seconds = unit.empty() && loaded.indexName != "frame" ? 1 : secondsOf(unit);
    if (seconds == 0)
      throw Error(ErrorCode::InvalidArgument,
                  what + " counts its frames by '" + (unit.empty() ? loaded.indexName : unit) +
                      "', which is no unit of time: give the times of its frames in seconds.");
    std::vector<double> times = loaded.indexValues;
    for (double& time : times)
      time *= seconds;
    return times;
  }
  if (loaded.frameSeconds > 0) return even(loaded.firstSeconds, loaded.frameSeconds, frames);
  if (bids.interval > 0) return even(0, bids.interval, frames);
  throw Error(
      ErrorCode::InvalidArgument,
      what + " does not say when its frames were acquired: give their times, or the time from one to the "
             "next, in seconds.");
}

/// Natural order: "frame2" comes before "frame10".
bool before(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto number = [&](const std::string& s, std::size_t& at) {
        const std::size_t begin = s.find_first_not_of('0', at);
        std::size_t end = at;
        while (end < s.size() && digit(s[end]))
          ++end;
        std::string text = begin < end ? s.substr(begin, end - begin) : std::string();
        at = end;
        return text;
      };
      const std::string x = number(a, i), y = number(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

std::vector<double> readTimesFile(const fs::path& path) {
  std::vector<double> times;
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' '))
      line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const auto time = wholeTextNumber(line);
    if (!time)
      throw Error(ErrorCode::FileFormat, quoted(path) + " has the line '" + line +
                                             "' that is not a number: give one time in seconds per line.");
    times.push_back(*time);
  }
  return times;
}

constexpr const char* kTimesFile = "times.txt";

/// Sorted.
std::vector<fs::path> imagesIn(const fs::path& folder) {
  static const std::set<std::string> images{".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".mnc"};
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && images.contains(fullExtension(entry.path())))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return before(utf8(a.filename()), utf8(b.filename()));
  });
  return files;
}

TimeSeries readFolder(const fs::path& folder, const TimeSeriesOptions& options) {
  const std::vector<fs::path> files = imagesIn(folder);
  const std::string what = quoted(folder);
  if (files.empty())
    throw Error(
        ErrorCode::UnsupportedImage,
        what +
            " holds no image of a frame (NIfTI, NRRD, MetaImage or MINC2): give a folder with one image per "
            "frame, or one 4D file.");
  TimeSeries series;
  for (const fs::path& file : files) {
    Volume frame = readVolume(file);
    if (series.frames.empty())
      series.geometry = frame.geometry;
    else if (!sameGrid(series.geometry, frame.geometry))
      throw Error(ErrorCode::Geometry, quoted(file) + " lies on another grid than " + quoted(files.front()) +
                                           ": resample all frames to one first.");
    series.frames.push_back(std::move(frame.voxels));
  }
  series.times = givenTimes(options, files.size(), what);
  if (!series.times.empty()) return series;
  const fs::path times = folder / kTimesFile;
  if (!isFile(times))
    throw Error(ErrorCode::InvalidArgument,
                what + " does not say when its frames were acquired: put their times into times.txt, in "
                       "seconds, one per line, or give them.");
  series.times = readTimesFile(times);
  checkCount(series.times, files.size(), what);
  return series;
}

} // namespace

std::vector<fs::path> frameFiles(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder, ignored) && isFile(folder / kTimesFile) ? imagesIn(folder)
                                                                          : std::vector<fs::path>();
}

TimeSeries readTimeSeries(const fs::path& path, const TimeSeriesOptions& options) {
  std::error_code ignored;
  TimeSeries series;
  const std::string what = quoted(path);
  if (fs::is_directory(path, ignored)) {
    series = readFolder(path, options);
    if (!options.sliceTimes.empty())
      series.sliceTiming = readSliceTiming(options.sliceTimes, series.geometry);
  } else {
    LoadedFrames loaded = loadFrames(path);
    if (loaded.vectors)
      throw Error(ErrorCode::UnsupportedImage,
                  what +
                      " has several values per voxel (vectors or tensors) and no frames of a dynamic scan.");
    if (isFile(withEnding(path, ".bval")) || isFile(withEnding(path, ".bvals")))
      throw Error(
          ErrorCode::UnsupportedImage,
          what +
              " is a diffusion scan (there are b-values beside it): its frames differ by their gradient, not "
              "by time.");
    series.geometry = loaded.geometry;
    if (loaded.frames.size() > 1) {
      const fs::path sidecar = sidecarOf(path);
      const BidsTimes bids = readBidsTimes(sidecar);
      series.times = timesOf(loaded, bids, path, options);
      series.sliceTiming = sliceTimingOf(loaded, bids, sidecar, options.sliceTimes);
    }
    series.frames = std::move(loaded.frames);
  }
  const fs::path name = path.has_filename() ? path.filename() : path.parent_path().filename();
  series.name = utf8(name.empty() ? path : name);
  checkTimeSeries(series);
  return series;
}

std::string remarkOnPairs(const TimeSeries& series) {
  constexpr std::int64_t fewest = 12;
  if (series.size() < fewest) return {};
  // Between consecutive frames: how much the mean changes, and how much the voxels do.
  std::vector<double> moves;
  std::array<std::vector<double>, 2> changes;
  for (std::size_t f = 1; f < series.frames.size(); ++f) {
    double sum = 0, squared = 0;
    for (std::size_t v = 0; v < series.frames[f].size(); ++v) {
      const float d = series.frames[f][v] - series.frames[f - 1][v];
      if (!std::isfinite(d)) continue;
      sum += static_cast<double>(d);
      squared += static_cast<double>(d) * static_cast<double>(d);
    }
    moves.push_back(sum);
    changes[f % 2].push_back(squared);
  }
  std::int64_t turns = 0;
  for (std::size_t f = 1; f < moves.size(); ++f)
    turns += moves[f] * moves[f - 1] < 0;
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  const double a = median(changes[0]), b = median(changes[1]);
  const bool alternates = static_cast<double>(turns) >= 0.95 * static_cast<double>(moves.size() - 1);
  const bool paired = std::max(a, b) >= 4 * std::min(a, b) && std::max(a, b) > 0;
  if (!alternates && !paired) return {};
  return (series.name.empty() ? "The series" : series.name) +
         " looks like pairs of label and control (arterial spin labelling), acquired in turn: its frames are "
         "then not a time course, and interpolating between them is meaningless.";
}

} // namespace innergs
