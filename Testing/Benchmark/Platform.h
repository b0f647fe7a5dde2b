#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// What only the operating system knows.
namespace innergs::bench {

/// Largest resident memory of this process so far, bytes; 0: unknown.
std::int64_t peakMemory();
/// E.g. "AMD EPYC 9755"; empty: unknown.
std::string processorModel();
/// Runs a program and waits; its output goes to the end of `log`.
struct RunStatus {
  int code = 0;
  bool interrupted = false; // by Ctrl-C
};
RunStatus runProgram(const std::vector<std::string>& words, const std::string& log);

} // namespace innergs::bench
