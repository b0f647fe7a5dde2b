#include "CLI/Options.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/ReconstructionJob.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"
#include "Text/SentenceEncoder.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace innergs::cli {
namespace {

std::vector<double> parseNumbers(const std::string& text, const std::string& option) {
  std::vector<double> values;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const auto value = wholeTextNumber(word);
    if (!value || !std::isfinite(*value))
      throw CLI::ValidationError(option, "'" + word + "' is not a number");
    values.push_back(*value);
    begin = end + 1;
  }
  return values;
}

/// Wraps a text to the space beside the options' names.
std::string wrapped(const std::string& text) {
  std::string lines;
  std::size_t length = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (!lines.empty()) lines += length + end - begin > 96 ? '\n' : ' ';
    length = lines.empty() || lines.back() == '\n' ? end - begin : length + 1 + end - begin;
    lines.append(text, begin, end - begin);
    begin = end + 1;
  }
  return lines;
}

std::string typeName(const Setting& row) {
  using Type = Setting::Type;
  if (row.type() == Type::Choice) return row.rangeText().substr(std::string("one of ").size());
  if (row.type() == Type::Integer || row.type() == Type::Natural) return "N";
  return row.type() == Type::Real ? "X" : "NAME";
}

std::string helpOf(const Setting& row) {
  std::string text = row.text, notes = automaticText(row);
  if (text.ends_with('.')) text.pop_back();
  const bool number = row.type() == Setting::Type::Integer || row.type() == Setting::Type::Real;
  if (const std::string range = number ? row.rangeText() : ""; !range.empty()) notes += "; " + range;
  if (*row.unit) notes += (notes.ends_with(row.rangeText()) ? " " : "; ") + std::string(row.unit);
  if (*row.zero) notes += std::string("; 0: ") + row.zero;
  return text + " [" + notes + "]";
}

} // namespace

CLI::Option* addSetting(CLI::App& app, Settings& settings, const std::string& name, const std::string& help) {
  const Setting& row = settingNamed(name);
  const std::string option = "--" + row.option();
  const auto set = [&row, &settings, option](const std::string& text) {
    try {
      row.setText(settings, row.member.optional && text == "auto" ? "" : text);
    } catch (const Error& error) {
      throw CLI::ValidationError(option, error.what());
    }
    row.check(settings);
  };
  const std::string text = wrapped(help.empty() ? helpOf(row) : help);
  if (row.type() == Setting::Type::Flag)
    return app.add_flag_function(
        option + ",!--no-" + row.option(), [set](std::int64_t count) { set(count > 0 ? "true" : "false"); },
        text);
  return app.add_option_function<std::string>(option, set, text)->type_name(typeName(row));
}

void addSettings(CLI::App& app, Settings& settings) {
  CLI::Option_group* group = nullptr;
  std::string title;
  for (const Setting& row : settingsTable()) {
    if (row.group == Setting::Group::Dynamic) continue;
    const std::string next = row.group == Setting::Group::Basic ? "Settings" : groupTitle(row.group);
    if (!group || next != title) group = app.add_option_group(title = next);
    addSetting(*group, settings, row.name);
  }
}

CLI::Option* addNumbers(CLI::App& app, const std::string& name, std::vector<double>& target,
                        const std::vector<std::size_t>& counts, const std::string& unit,
                        const std::string& help) {
  const auto parse = [=, &target](const std::string& text) {
    target = parseNumbers(text, name);
    if (counts.empty() || std::find(counts.begin(), counts.end(), target.size()) != counts.end()) return;
    std::string expected;
    for (const auto count : counts)
      expected += (expected.empty() ? "" : " or ") + std::to_string(count);
    throw CLI::ValidationError(name, fmt::format("takes {} comma-separated number{}, not {}", expected,
                                                 counts.back() == 1 ? "" : "s", target.size()));
  };
  return app.add_option_function<std::string>(name, parse, help)->type_name(unit);
}

CLI::Option* addTextModel(CLI::App& app, std::string& folder) {
  return addOption(
      app, "--text-model", folder, "FOLDER",
      "Folder with model.onnx and vocab.txt of a sentence embedding (all-MiniLM-L6-v2), which OpenVINO\n"
      "runs: suggests segments for words that the lexicon does not know [INNERGS_TEXT_MODEL]");
}

SentenceModel useTextModel(const std::string& folder) {
  if (!folder.empty()) setSentenceFolder(folder);
  SentenceModel model = sentenceModel();
  if (!folder.empty() && !model.embedding) throw Error(ErrorCode::FileNotFound, model.problem);
  return model;
}

void addCalibration(CLI::App& app, std::string& file) {
  app.add_option("--calibration", file,
                 "Calibration of tracked ultrasound (.igs.mha) whose file has no transform ImageToProbe: a\n"
                 "PLUS configuration (.xml), or a text file of its 16 numbers, row by row")
      ->type_name("FILE");
}

void addReading(CLI::App& app, ReadOptions& reading) {
  addOption(app, "--frame", reading.frame, "N", "Frame to take from a 4D file, from 0")
      ->check(CLI::NonNegativeNumber);
  addOption(app, "--series", reading.series, "N", "Series to take from a DICOM folder, from 1 [the only one]")
      ->check(CLI::PositiveNumber);
}

CLI::Option* addOutputType(CLI::App& app, OutputType& type) {
  return addChoice<OutputType>(app, "--type", type,
                               {{"float", OutputType::Float32},
                                {"uint8", OutputType::UInt8},
                                {"int16", OutputType::Int16},
                                {"uint16", OutputType::UInt16},
                                {"int32", OutputType::Int32}},
                               "Voxel type of the output; rejected if the values do not fit [float]");
}

std::shared_ptr<FieldDevice> renderDevice(const std::string& asked, const GaussianField& field,
                                          std::int64_t samples, Selection selection) {
  std::string problem;
  auto device = renderingDevice(asked, field, samples, "", selection, &problem);
  warn(problem);
  return device;
}

void Frame::add(CLI::App& app) {
  app.add_flag("--ras", ras,
               "Positions and directions are RAS, as 3D Slicer and the app show them (x to the patient's\n"
               "right, y to the front, z to the head) [LPS: to the left, to the back, to the head]");
}

Span reach(const GridGeometry& domain, const Vec3& direction) {
  Span span;
  for (const Vec3& corner : domain.corners()) {
    const double at = dot(corner, direction);
    span.low = std::min(span.low, at);
    span.high = std::max(span.high, at);
  }
  return span;
}

Region GridOptions::region() const {
  const Vec3 a = frame.turned({roi[0], roi[2], roi[4]}), b = frame.turned({roi[1], roi[3], roi[5]});
  return frame.ras ? Region{{b[0], b[1], a[2]}, {a[0], a[1], b[2]}} : Region{a, b};
}

void GridOptions::checkMeets(const GridGeometry& grid) const {
  std::array<Span, 3> box;
  bool meets = true;
  for (int a = 0; a < 3; ++a) {
    Vec3 axis{0, 0, 0};
    axis[a] = 1;
    box[a] = reach(grid, frame.turned(axis));
    if (roi[2 * a] >= roi[2 * a + 1]) return; // empty: reported elsewhere
    meets = meets && roi[2 * a] < box[a].high && roi[2 * a + 1] > box[a].low;
  }
  if (meets) return;
  throw Error(
      ErrorCode::Geometry,
      fmt::format("The region of interest lies outside the image, which reaches from {:.1f} to {:.1f} (x), "
                  "{:.1f} to {:.1f} (y) and {:.1f} to {:.1f} (z, all {}): choose a region inside.",
                  box[0].low, box[0].high, box[1].low, box[1].high, box[2].low, box[2].high, frame.name()));
}

void GridOptions::add(CLI::App& app, const std::string& fallbackHelp) {
  auto* spacingOption =
      addNumbers(app, "--spacing", spacing, {1, 3}, "MM",
                 "Voxel size of the output in mm: one number or x,y,z [" + fallbackHelp + "]");
  addOption(app, "--reference", reference, "IMAGE", "Image whose voxel grid the output uses")
      ->excludes(spacingOption);
  addNumbers(app, "--roi", roi, {6}, "MM",
             "Only this box: xmin,xmax,ymin,ymax,zmin,zmax in mm in patient space, LPS (x grows to the\n"
             "patient's left, y to the back, z to the head) or, with --ras, RAS");
  frame.add(app);
}

GridGeometry GridOptions::choose(const GridGeometry& domain, const GridGeometry& fallback) const {
  GridGeometry grid = fallback;
  if (!reference.empty()) {
    grid = readVolume(reference).geometry;
  } else if (!spacing.empty()) {
    const Vec3 size = spacing.size() == 1 ? Vec3{spacing[0], spacing[0], spacing[0]}
                                          : Vec3{spacing[0], spacing[1], spacing[2]};
    grid = withSpacing(domain, size);
  }
  if (!roi.empty()) {
    checkMeets(grid);
    grid = cropped(grid, region());
  }
  return grid;
}

void writeRendered(const Volume& volume, const GaussianField& field, const std::filesystem::path& path,
                   OutputType type) {
  VoxelValues values(volume.voxels);
  if (!field.gaussians.empty()) { // a part of the model may be nearly uniform
    const auto [low, high] =
        std::minmax_element(field.gaussians.begin(), field.gaussians.end(),
                            [](const Gaussian& a, const Gaussian& b) { return a.intensity < b.intensity; });
    values.span =
        std::max(values.span, std::abs(field.intensityScale) * (double(high->intensity) - low->intensity));
  }
  warn(writeVolume(volume, path, type, values));
}

GaussianField loadField(const std::filesystem::path& path, std::optional<double> fill) {
  GaussianField field = readModel(path).field;
  if (fill && field.support.voxels.empty())
    throw Error(ErrorCode::InvalidArgument,
                quoted(path) + " was not fitted inside a mask, so nothing is outside: omit --fill.");
  if (fill) field.fill = static_cast<float>(*fill);
  return field;
}

void addFill(CLI::App& command, std::optional<double>& fill) {
  const SettingRange& range = settingNamed("fill").range;
  addOption(command, "--fill", fill, "VALUE", "Value outside the mask [the model's own]")
      ->check(CLI::Range(range.lowest, range.highest));
}

bool looksLikeModel(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return false;
  if (isPly(path) || fullExtension(path) == ".innergs") return true;
  char start[9] = {};
  std::ifstream(path, std::ios::binary).read(start, sizeof(start));
  return start[8] == '{';
}

void warn(const std::string& sentence) {
  if (!sentence.empty()) fmt::print(stderr, "innergs: warning: {}\n", sentence);
}

void checkMemory(std::int64_t bytes, const std::string& what) {
  const std::int64_t available = availableMemory();
  if (available > 0 && bytes > available)
    throw Error(ErrorCode::Memory,
                fmt::format("{} needs about {} of memory, but only {} is available: choose a "
                            "larger --spacing or a smaller region.",
                            what, bytesText(static_cast<double>(bytes)),
                            bytesText(static_cast<double>(available))));
}

} // namespace innergs::cli
