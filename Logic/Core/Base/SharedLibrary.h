#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// Opens a shared library for the rest of the program. Null, and `problem` in the system's words, when it
/// cannot be.
void* openSharedLibrary(const std::filesystem::path& file, std::string& problem);
/// Null when the library has no such symbol.
void* sharedSymbol(void* library, const char* name);

/// "libname.so", "libname.dylib" or "name.dll".
std::string sharedLibraryName(const std::string& name);
/// The folders of the library or program that this code is part of, and of the executable.
std::vector<std::filesystem::path> programFolders();

} // namespace innergs
