#include "Core/ReconstructionJob.h"

#include <fstream>
#include <string>

#if defined(_WIN32)
#define NOMINMAX
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
/// Linux's own estimate, and the limit of the control group when there is one; other systems have neither
/// file: unknown.
std::int64_t availableMemory() {
  std::int64_t available = 0;
  std::ifstream info("/proc/meminfo");
  for (std::string key, unit; info >> key;) {
    std::int64_t kib = 0;
    info >> kib;
    std::getline(info, unit);
    if (key == "MemAvailable:") available = kib * 1024;
  }
  std::int64_t limit = 0, used = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit &&
      std::ifstream("/sys/fs/cgroup/memory.current") >> used && limit > used &&
      (available == 0 || limit - used < available))
    available = limit - used;
  return available;
}
#endif

} // namespace innergs
