#pragma once
#include <filesystem>
#include <system_error>

namespace innergs {

/// Replaces a file by a new one, with a version for each operating system.

/// Creates an empty file: with the user's default permissions, or for the owner only if it is to replace an
/// existing `target`.
std::error_code createReplacement(const std::filesystem::path& file, const std::filesystem::path& target);

/// Moves `file` to `target`, which need not exist, once its bytes are on disk. Keeps an existing target's
/// permissions and, if allowed, owner and group.
std::error_code replaceFile(const std::filesystem::path& file, const std::filesystem::path& target);

} // namespace innergs
