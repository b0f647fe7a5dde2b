#pragma once
#include "Core/Device/Devices.h"
#include "Core/Image/Region.h"
#include "Core/Model/GaussianField.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/VolumeIO.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace innergs::cli {

/// An option of comma-separated finite numbers, e.g. "--spacing 1,1,2"; `counts` lists how many may be given
/// (empty: any).
CLI::Option* addNumbers(CLI::App& app, const std::string& name, std::vector<double>& target,
                        const std::vector<std::size_t>& counts, const std::string& help);

/// An option with a few named values.
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

/// The option of one setting, with what the table says of it or another help; out of range throws Error.
CLI::Option* addSetting(CLI::App& app, Settings& settings, const std::string& name,
                        const std::string& help = "");
/// The options of all settings, in the table's groups.
void addSettings(CLI::App& app, Settings& settings);

/// --frame and --series.
void addReading(CLI::App& app, ReadOptions& reading);
CLI::Option* addOutputType(CLI::App& app, OutputType& type);
/// The field where it is rendered fastest, for so many samples; null: the CPU. auto: a GPU takes longer to
/// start than the CPU to render a few million.
std::shared_ptr<FieldDevice> renderDevice(const std::string& asked, const GaussianField& field,
                                          std::int64_t samples, Selection selection);

/// The frame of the positions and directions that a person gives and is told: LPS or, with --ras, RAS.
struct Frame {
  bool ras = false;

  void add(CLI::App& app);
  const char* name() const { return ras ? "RAS mm" : "LPS mm"; }
  /// From the frame to LPS, and back: the same turn.
  Vec3 turned(const Vec3& v) const { return ras ? Vec3{-v[0], -v[1], v[2]} : v; }
};

/// From where to where.
struct Span {
  double low = INFINITY, high = -INFINITY;
};
/// How far a lattice's box reaches along a direction (LPS), mm.
Span reach(const GridGeometry& domain, const Vec3& direction);

/// The lattice asked for: "--spacing" over the box of `domain`, "--reference" image or, with neither,
/// `fallback`.
struct GridOptions {
  std::vector<double> spacing;
  std::string reference;
  std::vector<double> roi;
  Frame frame; // of the region

  void add(CLI::App& app, const std::string& fallbackHelp);
  bool given() const { return !spacing.empty() || !reference.empty() || !roi.empty(); }
  /// The box that --roi gives (LPS).
  Region region() const;
  /// Throws Error(Geometry) with the lattice's box when the region lies beside it.
  void checkMeets(const GridGeometry& grid) const;
  GridGeometry choose(const GridGeometry& domain, const GridGeometry& fallback) const;
};

/// Writes rendered values of a field; a warning where the voxel type cuts some off.
void writeRendered(const Volume& volume, const GaussianField& field, const std::filesystem::path& path,
                   OutputType type);

/// Reads a model file or a PLY.
GaussianField loadField(const std::filesystem::path& path, std::optional<double> fill = {});
/// --fill, for loadField().
void addFill(CLI::App& command, std::optional<double>& fill);
/// True when the file begins as a model or a PLY does, so that it is not an image.
bool looksLikeModel(const std::filesystem::path& path);

/// Throws Error(Memory) when `bytes` are more than is available.
void checkMemory(std::int64_t bytes, const std::string& what);

} // namespace innergs::cli
