#include "IO/BidsSidecar.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/GridGeometry.h"
#include "IO/FilePath.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace fs = std::filesystem;
using nlohmann::json;

namespace innergs {
namespace {

[[noreturn]] void fail(const std::string& sentence) {
  throw Error(ErrorCode::FileFormat, sentence);
}

SliceTiming along(std::vector<double> times, const std::string& direction, int axis, const GridGeometry& grid,
                  const std::string& what) {
  SliceTiming timing{axis, std::move(times)};
  if (!direction.empty()) {
    timing.axis = direction[0] - 'i';
    if (timing.axis < 0 || timing.axis > 2 || (direction.size() > 1 && direction.substr(1) != "-"))
      fail(what + " has a SliceEncodingDirection '" + direction +
           "'; correct it to one of i, j, k, i-, j-, k-.");
  }
  const auto slices = static_cast<std::size_t>(grid.size[timing.axis]);
  if (timing.times.size() != slices)
    fail(what + " has " + std::to_string(timing.times.size()) + " slice times for " + std::to_string(slices) +
         " slices: correct or remove them.");
  if (direction.ends_with('-')) std::reverse(timing.times.begin(), timing.times.end());
  const auto [first, last] = std::minmax_element(timing.times.begin(), timing.times.end());
  if (*first == *last) timing.times.clear(); // all at once
  return timing;
}

/// Empty for a file that is missing or no JSON object.
json objectIn(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return json::object();
  std::ifstream in(file, std::ios::binary);
  json values = json::parse(in, nullptr, false);
  return values.is_object() ? values : json::object();
}

} // namespace

fs::path sidecarOf(const fs::path& image) {
  return withEnding(image, ".json");
}

BidsTimes readBidsTimes(const fs::path& file) {
  BidsTimes times;
  const json values = objectIn(file);
  const auto list = [&](const char* name) {
    std::vector<double> numbers;
    if (const auto found = values.find(name); found != values.end() && found->is_array())
      for (const json& number : *found) {
        if (!number.is_number())
          fail(quoted(file) + " has a " + name + " that is not a list of numbers (s); correct it.");
        numbers.push_back(number.get<double>());
      }
    return numbers;
  };
  times.frames = list("VolumeTiming");
  times.slices = list("SliceTiming");
  if (const auto interval = values.find("RepetitionTime"); interval != values.end() && interval->is_number())
    times.interval = interval->get<double>();
  if (const auto direction = values.find("SliceEncodingDirection");
      direction != values.end() && direction->is_string())
    times.direction = direction->get<std::string>();
  return times;
}

BidsSlices readBidsSlices(const fs::path& file, int axis, const GridGeometry& grid) {
  BidsSlices slices{axis, 0, {}};
  const json values = objectIn(file);
  bool backwards = false;
  if (const auto found = values.find("SliceEncodingDirection"); found != values.end()) {
    const std::string direction = found->is_string() ? found->get<std::string>() : "";
    if (direction.empty() || direction[0] < 'i' || direction[0] > 'k') return slices;
    slices.axis = direction[0] - 'i';
    backwards = direction.ends_with('-');
  }
  if (const auto found = values.find("SliceThickness"); found != values.end() && found->is_number())
    slices.thickness = std::max(0.0, found->get<double>());
  const auto found = values.find("SliceTiming");
  if (found == values.end() || !found->is_array() ||
      std::ssize(*found) != grid.size[static_cast<std::size_t>(slices.axis)] ||
      !std::all_of(found->begin(), found->end(), [](const json& time) { return time.is_number(); }))
    return slices;
  slices.times = found->get<std::vector<double>>();
  if (backwards) std::reverse(slices.times.begin(), slices.times.end());
  return slices;
}

SliceTiming sliceTimingFrom(const std::string& text, const std::string& direction, int axis,
                            const GridGeometry& grid, const std::string& what) {
  constexpr const char* blanks = " \t\r\n,;[]";
  std::vector<double> times;
  for (std::size_t at = text.find_first_not_of(blanks); at != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(blanks, at), text.size());
    const std::string word = text.substr(at, end - at);
    const auto time = wholeTextNumber(word);
    if (!time) fail(what + " has the slice time '" + word + "', which is no number (s): correct it.");
    times.push_back(*time);
    at = text.find_first_not_of(blanks, end);
  }
  return along(std::move(times), direction, axis, grid, what);
}

std::optional<SliceTiming> sliceTimingFrom(const BidsTimes& times, int axis, const GridGeometry& grid,
                                           const std::string& what) {
  if (times.slices.empty()) return std::nullopt;
  return along(times.slices, times.direction, axis, grid, what);
}

std::optional<SliceTiming> bidsSliceTiming(const fs::path& file, int axis, const GridGeometry& grid) {
  return sliceTimingFrom(readBidsTimes(file), axis, grid, quoted(file));
}

SliceTiming readSliceTiming(const fs::path& file, const GridGeometry& grid, int axis) {
  checkInputFile(file);
  if (fullExtension(file) == ".json") {
    if (auto timing = bidsSliceTiming(file, axis, grid)) return *timing;
    fail(quoted(file) + " has no SliceTiming, a list of one time (s) per slice: choose a BIDS file that has "
                        "it, or text with these times.");
  }
  std::ifstream in(file, std::ios::binary);
  return sliceTimingFrom({std::istreambuf_iterator<char>(in), {}}, "", axis, grid, quoted(file));
}

} // namespace innergs
