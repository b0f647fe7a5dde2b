#include "Core/ReconstructionJob.h"

#include <algorithm>
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
  std::int64_t reclaimable = 0; // page cache that the kernel gives back
  std::ifstream stat("/sys/fs/cgroup/memory.stat");
  std::int64_t value = 0;
  for (std::string key; stat >> key >> value;)
    if (key == "inactive_file") reclaimable = value;
  std::int64_t limit = 0, used = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit &&
      std::ifstream("/sys/fs/cgroup/memory.current") >> used) {
    const std::int64_t room =
        std::max<std::int64_t>(0, limit - std::max<std::int64_t>(0, used - reclaimable));
    if (available == 0 || room < available) available = room;
  }
  return available;
}
#endif

} // namespace innergs
