#include "Core/Base/ThreadPriority.h"

#include <algorithm>

#if defined(_WIN32)
#define NOMINMAX
#include <windows.h>
#elif defined(__APPLE__)
#include <pthread.h>
#include <sys/qos.h>
#elif defined(__linux__)
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace innergs {
namespace {

thread_local bool lowered = false;

} // namespace

void lowerThreadPriority() {
  if (lowered) return;
  lowered = true;
#if defined(_WIN32)
  SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_BELOW_NORMAL);
#elif defined(__APPLE__)
  pthread_set_qos_class_self_np(QOS_CLASS_UTILITY, 0);
#elif defined(__linux__)
  // A third of the main thread's share when both want a core. On Linux each thread has its own nice value,
  // which the threads it starts inherit.
  constexpr int behind = 5;
  const int main = getpriority(PRIO_PROCESS, static_cast<id_t>(getpid()));
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), std::min(main + behind, 19));
#endif
}

bool threadPriorityLowered() {
  return lowered;
}

} // namespace innergs
