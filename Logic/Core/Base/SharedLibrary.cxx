#include "Core/Base/SharedLibrary.h"

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#else
#include <dlfcn.h>
#endif
#ifdef __linux__
#include <cstdint>
#include <elf.h>
#include <fstream>
#endif

namespace innergs {
namespace {

#ifdef __linux__
/// The loader silently maps a truncated library and crashes later; the section headers are at the end of the
/// file, so they reveal the truncation.
bool cutShort(const std::filesystem::path& file) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(file, ignored);
  Elf64_Ehdr header{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(reinterpret_cast<char*>(&header), sizeof header)) return false; // the loader reports it
  if (header.e_ident[EI_CLASS] != ELFCLASS64) return false;
  return header.e_shoff + std::uint64_t{header.e_shentsize} * header.e_shnum > size;
}
#endif

} // namespace

#ifdef _WIN32

void* openSharedLibrary(const std::filesystem::path& file, std::string& problem) {
  const HMODULE module = LoadLibraryExW(file.c_str(), nullptr,
                                        LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR | LOAD_LIBRARY_SEARCH_DEFAULT_DIRS);
  if (!module) problem = "error " + std::to_string(GetLastError());
  return module;
}

void* sharedSymbol(void* library, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
}

std::string sharedLibraryName(const std::string& name) {
  return name + ".dll";
}

std::vector<std::filesystem::path> programFolders() {
  HMODULE here = nullptr;
  GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                     reinterpret_cast<LPCWSTR>(&programFolders), &here);
  std::vector<std::filesystem::path> folders;
  for (const HMODULE module : {here, static_cast<HMODULE>(nullptr)}) {
    wchar_t path[4096];
    const DWORD size = GetModuleFileNameW(module, path, 4096);
    if (size > 0 && size < 4096) folders.push_back(std::filesystem::path(path).parent_path());
  }
  return folders;
}

#else

void* openSharedLibrary(const std::filesystem::path& file, std::string& problem) {
#ifdef __linux__
  if (cutShort(file)) {
    problem = "the file is truncated";
    return nullptr;
  }
#endif
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    const char* words = dlerror();
    problem = words ? words : "unknown error";
  }
  return library;
}

void* sharedSymbol(void* library, const char* name) {
  return dlsym(library, name);
}

std::string sharedLibraryName(const std::string& name) {
#ifdef __APPLE__
  return "lib" + name + ".dylib";
#else
  return "lib" + name + ".so";
#endif
}

std::vector<std::filesystem::path> programFolders() {
  std::vector<std::filesystem::path> folders;
  Dl_info info{};
  // An executable's name may be relative to any folder in PATH; it is left out then.
  if (dladdr(reinterpret_cast<void*>(&programFolders), &info) && info.dli_fname &&
      std::filesystem::path(info.dli_fname).is_absolute())
    folders.push_back(std::filesystem::path(info.dli_fname).parent_path());
#ifdef __linux__
  std::error_code none;
  const auto executable = std::filesystem::read_symlink("/proc/self/exe", none);
  if (!none && !executable.empty()) folders.push_back(executable.parent_path());
#endif
  return folders;
}

#endif

} // namespace innergs
