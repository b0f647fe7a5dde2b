#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

namespace innergs {

/// Bytes that the limits of this process's control groups leave, the page cache that the kernel gives back
/// counted as free: the tightest of the group and all that hold it, version 1 or 2. Nothing: no limit known.
/// `root`: of the file system.
std::optional<std::int64_t> controlGroupRoom(const std::filesystem::path& root = "/");

} // namespace innergs
