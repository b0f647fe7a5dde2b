#include "IO/RecoveredFit.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/ModelMetadata.h"
#include "IO/Safetensors.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <sstream>
#include <utility>

namespace fs = std::filesystem;

namespace innergs {
namespace {

constexpr std::size_t kKept = 10;
constexpr std::size_t kLongestName = 60;        // bytes
constexpr const char* kRequested = "Requested"; // a note: every requested setting, one per line
constexpr const char* kInterval = "Interval";   // a note: s

std::string requestedText(const Settings& settings) {
  std::string text;
  for (const Setting& row : settingsTable())
    if (row.isIn(settings)) text += row.name + ("=" + row.textIn(settings)) + "\n";
  return text;
}

Settings requestedFrom(const std::string& text) {
  Settings settings;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find('=');
    if (at != std::string::npos) settingNamed(line.substr(0, at)).setText(settings, line.substr(at + 1));
  }
  return settings;
}

/// A name that any file system accepts.
std::string fileNameOf(std::string text) {
  for (char& c : text) {
    const bool ascii = static_cast<unsigned char>(c) < 128;
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-';
    if (ascii && !plain) c = '_';
  }
  if (text.size() > kLongestName) {
    std::size_t end = kLongestName;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) // inside a UTF-8 character
      --end;
    text.resize(end);
  }
  return text.empty() ? "fit" : text;
}

std::string timeText() { // UTC
  using namespace std::chrono;
  const auto now = floor<seconds>(system_clock::now());
  const auto day = floor<days>(now);
  const year_month_day date(day);
  const hh_mm_ss time(now - day);
  const auto two = [](auto number) {
    const std::string text = std::to_string(number);
    return text.size() < 2 ? "0" + text : text;
  };
  return std::to_string(static_cast<int>(date.year())) + two(static_cast<unsigned>(date.month())) +
         two(static_cast<unsigned>(date.day())) + "-" + two(time.hours().count()) +
         two(time.minutes().count()) + two(time.seconds().count());
}

fs::path freeName(const fs::path& folder, const std::string& inputs) {
  const std::string stem = fileNameOf(inputs) + "-" + timeText();
  std::error_code ignored;
  for (int n = 1;; ++n) {
    const std::string name = stem + (n > 1 ? "-" + std::to_string(n) : "") + ".innergs";
    fs::path file = folder / pathOf(name);
    if (!fs::exists(file, ignored)) return file;
  }
}

void makePrivate(const fs::path& folder) {
  std::error_code failed;
  if (fs::create_directories(folder, failed))
    fs::permissions(folder, fs::perms::owner_all, failed); // it will hold patients' scans
  if (!fs::is_directory(folder, failed))
    throw Error(ErrorCode::Io, "The folder " + quoted(folder) +
                                   " cannot be made: check the permissions of the one that it is in.");
}

using Write = std::function<void(const fs::path& file, const ModelNotes& notes)>;

fs::path writeInto(const fs::path& folder, const RecoveredFit& about, const std::string& settings,
                   const Write& write) {
  makePrivate(folder);
  ModelNotes notes{{"Version", INNERGS_VERSION},
                   {"Inputs", about.inputs},
                   {"Settings", settings},
                   {"Iterations", std::to_string(about.iterations)},
                   {kRequested, requestedText(about.settings)}};
  if (!about.mask.empty()) notes["Mask"] = about.mask;
  if (about.interval > 0) notes[kInterval] = exactText(about.interval);
  fs::path file = freeName(folder, about.inputs);
  write(file, notes);
  const std::vector<RecoveredFit> all = recoveredFits(folder);
  std::error_code ignored;
  for (std::size_t n = kKept; n < all.size(); ++n)
    fs::remove(all[n].file, ignored);
  return file;
}

} // namespace

fs::path writeRecoveredFit(const Model& model, const RecoveredFit& about, const fs::path& folder) {
  return writeInto(folder, about, settingsText(about.settings, 0),
                   [&](const fs::path& file, const ModelNotes& notes) { writeModel(model, file, notes); });
}

fs::path writeRecoveredFit(const StoppedDynamicFit& fit, const RecoveredFit& about, const fs::path& folder) {
  return writeInto(folder, about, dynamicSettingsText(about.settings),
                   [&](const fs::path& file, const ModelNotes& notes) {
                     writeDynamicModel(fit.field, file, notes, fit.state);
                   });
}

void writeStoppedFit(const DynamicResult& result, RecoveredFit& about, const fs::path& folder) {
  if (!result.field || result.state.empty()) return;
  about.dynamic = true;
  about.iteration = result.state.step;
  about.iterations = result.steps;
  about.file = writeRecoveredFit({*result.field, result.state}, about, folder);
}

void dropRecoveredFit(const fs::path& file, const fs::path& folder) {
  std::error_code ignored;
  if (!file.empty() && fs::equivalent(file.parent_path(), folder, ignored)) fs::remove(file, ignored);
}

std::vector<RecoveredFit> recoveredFits(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, RecoveredFit>> found;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const fs::path& path = at->path();
    if (path.extension() != ".innergs") continue;
    try {
      const SafetensorsFile file(path);
      const Metadata metadata(file, path);
      const ModelNotes notes = metadata.notes();
      const auto note = [&](const char* name) {
        const auto entry = notes.find(name);
        return entry == notes.end() ? std::string() : entry->second;
      };
      if (notes.find(kRequested) == notes.end()) continue;
      RecoveredFit fit;
      fit.file = path;
      fit.inputs = note("Inputs");
      fit.mask = note("Mask");
      fit.settings = requestedFrom(note(kRequested));
      fit.dynamic = isDynamic(file);
      fit.iteration =
          fit.dynamic ? metadata.parsed("refinement").at("step").get<int>() : metadata.integer("iteration");
      fit.interval = wholeTextNumber(note(kInterval)).value_or(0);
      fit.iterations = static_cast<int>(wholeTextNumber(note("Iterations")).value_or(0));
      found.emplace_back(fs::last_write_time(path), std::move(fit));
    } catch (const std::exception&) { // damaged, of another version, or gone meanwhile
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second.file) > std::pair(b.first, b.second.file);
  });
  std::vector<RecoveredFit> fits;
  for (auto& [time, fit] : found)
    fits.push_back(std::move(fit));
  return fits;
}

} // namespace innergs
