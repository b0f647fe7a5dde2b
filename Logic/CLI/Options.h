#pragma once
#include "Core/Device/Devices.h"
#include "Core/Image/Region.h"
#include "Core/Model/GaussianField.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/VolumeIO.h"
#include "Text/SentenceEmbedding.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace innergs::cli {

/// Adds an option; the help shows `unit` in the place of its value.
template <class T>
CLI::Option* addOption(CLI::App& app, const std::string& name, T& target, const std::string& unit,
                       const std::string& help) {
  return app.add_option(name, target, help)->type_name(unit);
}

/// Adds an option that takes comma-separated finite numbers, e.g. "--spacing 1,1,2"; `counts` lists the
/// allowed numbers of values (empty: any).
CLI::Option* addNumbers(CLI::App& app, const std::string& name, std::vector<double>& target,
                        const std::vector<std::size_t>& counts, const std::string& unit,
                        const std::string& help);

/// Adds an option with a few named values.
template <class T>
CLI::Option* addChoice(CLI::App& app, const std::string& name, T& target,
                       const std::vector<std::pair<std::string, T>>& choices, const std::string& help) {
  std::string names;
  for (const auto& choice : choices)
    names += (names.empty() ? "" : "|") + choice.first;
  return app
      .add_option_function<std::string>(
          name,
          [=, &target](const std::string& value) {
            for (const auto& choice : choices)
              if (choice.first == value) {
                target = choice.second;
                return;
              }
            throw CLI::ValidationError(name, "'" + value + "' is not one of " + names);
          },
          help)
      ->type_name(names);
}

/// Adds the option of one setting, with the table's help or another one; throws Error if out of range.
CLI::Option* addSetting(CLI::App& app, Settings& settings, const std::string& name,
                        const std::string& help = "");
/// Adds the options of all settings, in the table's groups.
void addSettings(CLI::App& app, Settings& settings);

/// How the images of tracked sweeps lie to the probe.
void addCalibration(CLI::App& app, std::string& file);

/// Adds --frame and --series.
void addReading(CLI::App& app, ReadOptions& reading);
CLI::Option* addOutputType(CLI::App& app, OutputType& type);
/// The field on the device that renders this many samples fastest; null: the CPU. auto: a GPU takes longer to
/// start than the CPU to render a few million samples.
std::shared_ptr<FieldDevice> renderDevice(const std::string& asked, const GaussianField& field,
                                          std::int64_t samples, Selection selection);

/// Adds --text-model: the folder of a sentence embedding.
CLI::Option* addTextModel(CLI::App& app, std::string& folder);
/// Lets queries use the sentence embedding in a folder; "": INNERGS_TEXT_MODEL's. Throws Error(FileNotFound)
/// for a folder without one.
SentenceModel useTextModel(const std::string& folder);

/// The frame of positions and directions in input and output: LPS or, with --ras, RAS.
struct Frame {
  bool ras = false;

  void add(CLI::App& app);
  const char* name() const { return ras ? "RAS mm" : "LPS mm"; }
  /// Converts between the frame and LPS, in either direction.
  Vec3 turned(const Vec3& v) const { return ras ? Vec3{-v[0], -v[1], v[2]} : v; }
};

/// An interval, mm.
struct Span {
  double low = INFINITY, high = -INFINITY;
};
/// The extent of a grid's box along a direction (LPS), mm.
Span reach(const GridGeometry& domain, const Vec3& direction);

/// The requested grid: "--spacing" over the box of `domain`, a "--reference" image or, with neither,
/// `fallback`.
struct GridOptions {
  std::vector<double> spacing;
  std::string reference;
  std::vector<double> roi;
  Frame frame; // of the region

  void add(CLI::App& app, const std::string& fallbackHelp);
  bool given() const { return !spacing.empty() || !reference.empty() || !roi.empty(); }
  /// The box given by --roi (LPS).
  Region region() const;
  /// Throws Error(Geometry), which states the grid's box, if the region does not overlap it.
  void checkMeets(const GridGeometry& grid) const;
  GridGeometry choose(const GridGeometry& domain, const GridGeometry& fallback) const;
};

/// Writes rendered values of a field; warns if the voxel type clips some of them.
void writeRendered(const Volume& volume, const GaussianField& field, const std::filesystem::path& path,
                   OutputType type);

/// Reads a model file or a PLY file.
GaussianField loadField(const std::filesystem::path& path, std::optional<double> fill = {});
/// Adds --fill, for loadField().
void addFill(CLI::App& command, std::optional<double>& fill);
/// Whether the file begins like a model or a PLY file, so that it is not an image.
bool looksLikeModel(const std::filesystem::path& path);

/// Prints a warning; "": none.
void warn(const std::string& sentence);

/// Throws Error(Memory) if `bytes` exceed the available memory.
void checkMemory(std::int64_t bytes, const std::string& what);

} // namespace innergs::cli
