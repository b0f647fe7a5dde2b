#pragma once
#include <string>
#include <vector>

/// Functions that depend on the operating system.
namespace innergs::bench {

/// E.g. "AMD EPYC 9755"; empty: unknown.
std::string processorModel();
/// Runs a program and waits; appends its output to `log`.
struct RunStatus {
  int code = 0;
  bool interrupted = false; // by Ctrl-C
};
RunStatus runProgram(const std::vector<std::string>& words, const std::string& log);

} // namespace innergs::bench
