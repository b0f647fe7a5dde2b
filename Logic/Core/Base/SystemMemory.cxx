#include "Core/Base/SystemMemory.h"
#include "Core/Base/ControlGroup.h"

#include <fstream>
#include <string>

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
// after windows.h
#include <psapi.h>
#elif defined(__APPLE__)
#include <sys/resource.h>
#endif

namespace innergs {

#if defined(_WIN32)
std::int64_t availableMemory() {
  MEMORYSTATUSEX status;
  status.dwLength = sizeof(status);
  return GlobalMemoryStatusEx(&status) ? static_cast<std::int64_t>(status.ullAvailPhys) : 0;
}

std::int64_t peakMemory() {
  PROCESS_MEMORY_COUNTERS counters{};
  return GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof(counters))
             ? static_cast<std::int64_t>(counters.PeakWorkingSetSize)
             : 0;
}
#else
namespace {

/// The kibibytes that a file such as /proc/meminfo gives for a key with its colon, in bytes; 0: not there.
std::int64_t bytesIn(const char* path, const std::string& name) {
  std::ifstream info(path);
  std::string key, rest;
  while (info >> key) {
    std::int64_t kib = 0;
    if (key == name && info >> kib) return kib * 1024;
    std::getline(info, rest);
  }
  return 0;
}

} // namespace

/// Linux's own estimate, limited by the control groups if there are any. Other systems have neither file, so
/// it is unknown there.
std::int64_t availableMemory() {
  const std::int64_t available = bytesIn("/proc/meminfo", "MemAvailable:");
  const auto room = controlGroupRoom();
  return room && (available == 0 || *room < available) ? *room : available;
}

std::int64_t peakMemory() {
#if defined(__APPLE__)
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::int64_t>(usage.ru_maxrss) : 0;
#else
  return bytesIn("/proc/self/status", "VmHWM:"); // ru_maxrss includes the parent's at fork
#endif
}
#endif

} // namespace innergs
