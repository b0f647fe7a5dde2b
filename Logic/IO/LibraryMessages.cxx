#include "IO/LibraryMessages.h"

#include <atomic>
#include <cstdio>
#include <mutex>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#else
#include <fcntl.h>
#include <unistd.h>
#endif

namespace innergs {
namespace {

#if defined(_WIN32)
int openNull() {
  return _open("NUL", _O_WRONLY);
}
int duplicate(int file) {
  return _dup(file);
}
void put(int file, int in) {
  _dup2(file, in);
}
void shut(int file) {
  _close(file);
}
#else
int openNull() {
  return open("/dev/null", O_WRONLY | O_CLOEXEC);
}
int duplicate(int file) {
  return fcntl(file, F_DUPFD_CLOEXEC, 3);
}
void put(int file, int in) {
  dup2(file, in);
}
void shut(int file) {
  close(file);
}
#endif

constexpr int kStandardError = 2;
std::atomic<bool> dropping{false};
std::mutex mutex;
int muting = 0; // number of live instances
int kept = -1;

} // namespace

void dropLibraryMessages() {
  dropping = true;
}

MuteStandardError::MuteStandardError() : muted_(dropping) {
  if (!muted_) return;
  const std::lock_guard lock(mutex);
  if (++muting > 1) return;
  std::fflush(stderr);
  const int nowhere = openNull();
  if (nowhere < 0) return;
  kept = duplicate(kStandardError);
  if (kept >= 0) put(nowhere, kStandardError);
  shut(nowhere);
}

MuteStandardError::~MuteStandardError() {
  if (!muted_) return;
  const std::lock_guard lock(mutex);
  if (--muting > 0 || kept < 0) return;
  std::fflush(stderr);
  put(kept, kStandardError);
  shut(kept);
  kept = -1;
}

} // namespace innergs
