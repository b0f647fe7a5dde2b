#pragma once
#include <QStringList>

namespace innergs::app {

/// The options of `innergs-app`.
struct CommandLine {
  QStringList files;
  bool sample = false, reconstruct = false, dark = false;
  QString screenshot; // a PNG file: write the window when everything asked for is done, and quit
};

/// Parses; false when the program is to end with *exitCode (help, version, wrong options).
bool parse(int argc, char** argv, CommandLine& line, int* exitCode);

} // namespace innergs::app
