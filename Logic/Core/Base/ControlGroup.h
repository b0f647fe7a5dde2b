#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

namespace innergs {

/// Bytes that this process's control groups (version 1 or 2) still allow: the tightest limit of the group and
/// its ancestors, with reclaimable page cache counted as free. Nothing when no limit is known.
/// `root`: of the file system.
std::optional<std::int64_t> controlGroupRoom(const std::filesystem::path& root = "/");

} // namespace innergs
