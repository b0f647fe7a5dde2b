#pragma once
#include "CLI/Options.h"
#include "Core/Job/ReconstructionJob.h"

namespace innergs::cli {

/// The options of `innergs reconstruct`.
struct ReconstructOptions {
  std::vector<std::string> inputs;
  std::optional<int> frame;
  std::string calibration;       // of tracked sweeps
  std::vector<int> series;       // none, one, or one per input folder
  std::vector<double> thickness; // none, one, or one per input
  std::optional<SliceProfile> profile;
  std::vector<std::string> masks; // none, one, or one per input
  GridOptions grid;
  Settings settings;
  double heldOut = 0;
  std::string resume;

  std::string output, saveModel, ply, report, slices, transforms, uncertainty, measured;
  OutputType type = OutputType::Float32;
  bool quiet = false;
};

void addOptions(CLI::App& app, ReconstructOptions& options);

} // namespace innergs::cli
