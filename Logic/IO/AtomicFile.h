#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace innergs {

/// Calls `write` with an empty temporary file in the target's folder (same extension) and, once it is on
/// disk, renames it over the target. On any exception removes the temporary file and leaves the target
/// unchanged. Links stay links; an existing file keeps its permissions and group. Throws Error(Io) if the
/// disk is full.
void writeAtomically(const std::filesystem::path& target,
                     const std::function<void(const std::filesystem::path&)>& write);

/// The same for bytes in memory.
void writeFileAtomically(const std::filesystem::path& target, std::string_view bytes);

/// Throws Error(InvalidArgument | Io) if `path` could not be written as a file: no name, no such folder. Call
/// it before the work starts.
void checkOutputFolder(const std::filesystem::path& path);

} // namespace innergs
