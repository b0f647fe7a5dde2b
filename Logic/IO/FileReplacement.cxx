#include "IO/FileReplacement.h"

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#else
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

namespace fs = std::filesystem;

namespace innergs {

#if defined(_WIN32)
namespace {

std::error_code lastError() {
  return {static_cast<int>(GetLastError()), std::system_category()};
}

} // namespace

std::error_code createReplacement(const fs::path& file, const fs::path&) {
  const HANDLE created =
      CreateFileW(file.c_str(), GENERIC_WRITE, 0, nullptr, CREATE_NEW, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (created == INVALID_HANDLE_VALUE) return lastError();
  CloseHandle(created);
  return {};
}

std::error_code replaceFile(const fs::path& file, const fs::path& target) {
  const HANDLE written = CreateFileW(file.c_str(), GENERIC_WRITE, FILE_SHARE_READ, nullptr, OPEN_EXISTING,
                                     FILE_ATTRIBUTE_NORMAL, nullptr);
  if (written == INVALID_HANDLE_VALUE) return lastError();
  const bool onDisk = FlushFileBuffers(written);
  const std::error_code failed = onDisk ? std::error_code() : lastError();
  CloseHandle(written);
  if (!onDisk) return failed;
  // The first flag keeps the target's access control list, which some file systems do not support.
  std::error_code ignored;
  if (fs::exists(target, ignored) && ReplaceFileW(target.c_str(), file.c_str(), nullptr, 0, nullptr, nullptr))
    return {};
  if (MoveFileExW(file.c_str(), target.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH))
    return {};
  return lastError();
}
#else
namespace {

std::error_code lastError() {
  return {errno, std::generic_category()};
}

class Descriptor {
public:
  Descriptor(const fs::path& path, int flags, mode_t mode = 0)
      : fd_(open(path.c_str(), flags | O_CLOEXEC, mode)) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return fd_; }

private:
  int fd_;
};

/// Never more accessible than `old`: if the group cannot be kept, its rights are reduced to everyone's.
std::error_code takeOver(int file, const struct stat& old) {
  mode_t mode = old.st_mode & 0777;
  if (fchown(file, old.st_uid, old.st_gid) != 0 && fchown(file, static_cast<uid_t>(-1), old.st_gid) != 0)
    mode = (mode & ~static_cast<mode_t>(070)) | ((mode & 07) << 3);
  return fchmod(file, mode) == 0 ? std::error_code() : lastError();
}

} // namespace

std::error_code createReplacement(const fs::path& file, const fs::path& target) {
  struct stat old;
  const mode_t mode = stat(target.c_str(), &old) == 0 ? 0600 : 0666; // minus the umask
  const Descriptor created(file, O_WRONLY | O_CREAT | O_EXCL, mode);
  return created >= 0 ? std::error_code() : lastError();
}

std::error_code replaceFile(const fs::path& file, const fs::path& target) {
  const Descriptor written(file, O_RDONLY);
  if (written < 0) return lastError();
  struct stat old;
  if (stat(target.c_str(), &old) == 0)
    if (const std::error_code failed = takeOver(written, old)) return failed;
  if (fsync(written) != 0 && errno != EINVAL && errno != ENOTSUP) return lastError(); // some cannot
  if (std::rename(file.c_str(), target.c_str()) != 0) return lastError();
  const Descriptor folder(target.has_parent_path() ? target.parent_path() : fs::path("."), O_RDONLY);
  if (folder >= 0) fsync(folder); // the file is already in place, so errors do not matter
  return {};
}
#endif

} // namespace innergs
