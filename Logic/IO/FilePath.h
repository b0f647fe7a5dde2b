#pragma once
#include "Core/Base/PathText.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace innergs {

/// 'path', for error messages.
std::string quoted(const std::filesystem::path& path);
/// The extension in lower case, including the one before .gz: ".nii.gz", ".mha", "" (none).
std::string fullExtension(const std::filesystem::path& path);
/// The same path with `ending` (UTF-8) in place of its full extension.
std::filesystem::path withEnding(const std::filesystem::path& path, const std::string& ending);

/// The absolute path of the file that a path resolves to through links, whether or not it exists; for
/// circular links, one of them.
std::filesystem::path followed(std::filesystem::path path);

/// Whether both paths refer to the same file, however they are written: relative, through links, as hard
/// links. Files need not exist yet.
bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws Error(FileNotFound | FileFormat) unless `path` is a readable, non-empty file; returns its size in
/// bytes.
std::uintmax_t checkInputFile(const std::filesystem::path& path);

} // namespace innergs
