#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace innergs {

/// Calls `write` with a temporary path in the target's folder (same extension) and renames it over the
/// target; on any exception the temporary file is removed and the target stays as it was. Throws Error(Io)
/// when the disk is full.
void writeAtomically(const std::filesystem::path& target,
                     const std::function<void(const std::filesystem::path&)>& write);

/// The same for bytes in memory.
void writeFileAtomically(const std::filesystem::path& target, std::string_view bytes);

} // namespace innergs
