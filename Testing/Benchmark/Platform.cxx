#include "Platform.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#if defined(_WIN32)
#include <windows.h>
#else
#include <csignal>
#include <sys/wait.h>
#endif
#if defined(__APPLE__)
#include <sys/sysctl.h>
#endif

namespace innergs::bench {
namespace {

/// The text after "name" and a colon in a file such as /proc/cpuinfo.
[[maybe_unused]] std::string valueIn(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(':');
    if (line.compare(0, name.size(), name) != 0 || colon == std::string::npos) continue;
    const auto first = line.find_first_not_of(" \t", colon + 1);
    return first == std::string::npos ? "" : line.substr(first);
  }
  return {};
}

} // namespace

std::string processorModel() {
#if defined(_WIN32)
  const char* model = std::getenv("PROCESSOR_IDENTIFIER");
  return model ? model : "";
#elif defined(__APPLE__)
  char model[256];
  std::size_t size = sizeof(model);
  return sysctlbyname("machdep.cpu.brand_string", model, &size, nullptr, 0) == 0 ? model : "";
#else
  return valueIn("/proc/cpuinfo", "model name");
#endif
}

RunStatus runProgram(const std::vector<std::string>& words, const std::string& log) {
  std::ostringstream command;
#if defined(_WIN32)
  command << '"'; // cmd strips the outer pair
  for (const auto& word : words)
    command << '"' << word << "\" ";
  command << ">>\"" << log << "\" 2>&1\"";
  const int status = std::system(command.str().c_str());
  return {status, status == static_cast<int>(STATUS_CONTROL_C_EXIT)};
#else
  const auto quoted = [](const std::string& word) {
    std::string text = "'";
    for (char c : word)
      text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
  };
  for (const auto& word : words)
    command << quoted(word) << ' ';
  command << ">>" << quoted(log) << " 2>&1";
  const int status = std::system(command.str().c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return {code, code == 128 + SIGINT};
#endif
}

} // namespace innergs::bench
