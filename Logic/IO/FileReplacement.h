#pragma once
#include <filesystem>
#include <system_error>

namespace innergs {

/// Replacing a file by a new one, which each operating system does in its own way.

/// Creates an empty file; as the user's default permissions say, or for the owner alone when it is to
/// replace an existing `target`.
std::error_code createReplacement(const std::filesystem::path& file, const std::filesystem::path& target);

/// Puts `file` in the place of `target`, which may not exist, once its bytes are on the disk. An existing
/// target's permissions and, where allowed, owner and group are kept.
std::error_code replaceFile(const std::filesystem::path& file, const std::filesystem::path& target);

} // namespace innergs
