#include "Core/Base/SystemMemory.h"
#include "Core/Base/ControlGroup.h"

#include <fstream>
#include <string>

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#endif

namespace innergs {

#if defined(_WIN32)
std::int64_t availableMemory() {
  MEMORYSTATUSEX status;
  status.dwLength = sizeof(status);
  return GlobalMemoryStatusEx(&status) ? static_cast<std::int64_t>(status.ullAvailPhys) : 0;
}
#else
/// Linux's own estimate, limited by the control groups if there are any. Other systems have neither file, so
/// it is unknown there.
std::int64_t availableMemory() {
  std::int64_t available = 0;
  std::ifstream info("/proc/meminfo");
  for (std::string key, unit; info >> key;) {
    std::int64_t kib = 0;
    info >> kib;
    std::getline(info, unit);
    if (key == "MemAvailable:") available = kib * 1024;
  }
  const auto room = controlGroupRoom();
  return room && (available == 0 || *room < available) ? *room : available;
}
#endif

} // namespace innergs
