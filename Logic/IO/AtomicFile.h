#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace innergs {

/// Calls `write` with an empty temporary file in the target's folder (same extension) and renames it over the
/// target once it is on the disk; on any exception the temporary file is removed and the target stays as it
/// was. Links stay links, an existing file keeps its permissions and group. Throws Error(Io) when the disk is
/// full.
void writeAtomically(const std::filesystem::path& target,
                     const std::function<void(const std::filesystem::path&)>& write);

/// The same for bytes in memory.
void writeFileAtomically(const std::filesystem::path& target, std::string_view bytes);

} // namespace innergs
