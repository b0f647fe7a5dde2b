#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// Loads a shared library for the rest of the program. On failure returns null and sets `problem` to the
/// system's message.
void* openSharedLibrary(const std::filesystem::path& file, std::string& problem);
/// Null if the library has no such symbol.
void* sharedSymbol(void* library, const char* name);

/// "libname.so", "libname.dylib" or "name.dll".
std::string sharedLibraryName(const std::string& name);
/// The folder of the library or program that contains this code, and the folder of the executable.
std::vector<std::filesystem::path> programFolders();

} // namespace innergs
