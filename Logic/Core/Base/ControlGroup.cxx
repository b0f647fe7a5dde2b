#include "Core/Base/ControlGroup.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace fs = std::filesystem;

namespace innergs {
namespace {

struct Names {
  const char *limit, *used, *reclaimable;
};
constexpr Names kVersion2{"memory.max", "memory.current", "inactive_file"};
constexpr Names kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};

std::optional<std::int64_t> roomIn(const fs::path& group, const Names& names) {
  std::int64_t limit = 0, used = 0;
  if (!(std::ifstream(group / names.limit) >> limit) || !(std::ifstream(group / names.used) >> used))
    return std::nullopt; // "max", or not a control-group file system
  std::int64_t reclaimable = 0, value = 0;
  std::ifstream stat(group / "memory.stat");
  for (std::string key; stat >> key >> value;)
    if (key == names.reclaimable) reclaimable = value;
  return std::max<std::int64_t>(0, limit - std::max<std::int64_t>(0, used - reclaimable));
}

} // namespace

std::optional<std::int64_t> controlGroupRoom(const fs::path& root) {
  std::optional<std::int64_t> least;
  std::ifstream groups(root / "proc/self/cgroup"); // one per line: "0::/group" or "4:memory:/group"
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool version2 = controllers == ",,";
    if (!version2 && controllers.find(",memory,") == std::string::npos) continue;
    const fs::path top = root / (version2 ? "sys/fs/cgroup" : "sys/fs/cgroup/memory");
    // A container may see its own group as the root, so missing groups are skipped.
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      const auto room = roomIn(group.empty() ? top : top / group, version2 ? kVersion2 : kVersion1);
      if (room && (!least || *room < *least)) least = room;
      if (group.empty()) break;
    }
  }
  return least;
}

} // namespace innergs
