#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

namespace innergs {

/// A path as UTF-8, the encoding of ITK, of error sentences and of JSON.
std::string utf8(const std::filesystem::path& path);
/// 'path', for error sentences.
std::string quoted(const std::filesystem::path& path);
/// The extension in lower case with what .gz compresses: ".nii.gz", ".mha", "" (none).
std::string fullExtension(const std::filesystem::path& path);

/// The file that a path leads to through links, absolute, whether or not it exists; a link when they lead
/// nowhere.
std::filesystem::path followed(std::filesystem::path path);

/// Whether both paths lead to one file, however they are spelt: relative, through links, as hard links; a
/// file need not exist yet.
bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws Error(FileNotFound | FileFormat) unless `path` is a readable file that is not empty; returns its
/// length in bytes.
std::uintmax_t checkInputFile(const std::filesystem::path& path);

} // namespace innergs
