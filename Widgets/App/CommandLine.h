#pragma once
#include <QStringList>

namespace innergs::app {

/// The options of `innergs-app`.
struct CommandLine {
  QStringList files;
  bool sample = false, reconstruct = false, dark = false;
  QString screenshot; // a PNG file: writes the window to it once everything is done, and quits
};

/// Parses the options; returns false if the program must end with *exitCode (help, version, wrong options).
bool parse(int argc, char** argv, CommandLine& line, int* exitCode);

} // namespace innergs::app
