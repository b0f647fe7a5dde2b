#include "Widgets/App/CommandLine.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace innergs::app {

bool parse(int argc, char** argv, CommandLine& line, int* exitCode) {
  CLI::App app("InnerGS: medical image slices become a continuous volume of 3D Gaussians.\n"
               "Research software; not for clinical use.",
               "innergs-app");
  std::vector<std::string> files;
  std::string screenshot;
  app.add_option("files", files, "Volumes, models, DICOM folders to open");
  app.add_flag("--sample", line.sample, "Open the sample brain");
  app.add_flag("--reconstruct", line.reconstruct,
               "Reconstruct from all volumes that were opened, as the panel is set");
  app.add_flag("--dark", line.dark, "Dark colours");
  app.add_option("--screenshot", screenshot, "Write the window to this PNG file when all is done, and quit");
  app.set_version_flag("--version", std::string(INNERGS_VERSION));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exitCode = app.exit(error);
    return false;
  }
  for (const std::string& file : files)
    line.files << QString::fromLocal8Bit(file.c_str());
  line.screenshot = QString::fromLocal8Bit(screenshot.c_str());
  return true;
}

} // namespace innergs::app
