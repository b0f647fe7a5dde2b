#include "ThreadShortage.h"

#ifdef __linux__
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <limits>
#include <new>

namespace {

constexpr int kAny = std::numeric_limits<int>::max();
std::atomic<int> remaining{kAny};

struct Call {
  void* (*start)(void*);
  void* argument;
};

void* counted(void* given) {
  const Call call = *static_cast<Call*>(given);
  delete static_cast<Call*>(given);
  void* result = call.start(call.argument);
  if (remaining != kAny) ++remaining;
  return result;
}

} // namespace

/// A program's own definition takes precedence over the C library's, also for calls by std::thread.
extern "C" __attribute__((visibility("default"))) int pthread_create(pthread_t* thread,
                                                                     const pthread_attr_t* attributes,
                                                                     void* (*start)(void*),
                                                                     void* argument) noexcept {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (remaining == kAny) return create(thread, attributes, start, argument);
  if (--remaining < 0) {
    ++remaining;
    return EAGAIN;
  }
  auto* call = new (std::nothrow) Call{start, argument};
  return call ? create(thread, attributes, counted, call) : EAGAIN;
}

innergs::test::ThreadShortage::ThreadShortage(int allowed) {
  remaining = allowed;
}

innergs::test::ThreadShortage::~ThreadShortage() {
  remaining = kAny;
}

bool innergs::test::ThreadShortage::known() {
  return true;
}
#else
innergs::test::ThreadShortage::ThreadShortage(int) {}

innergs::test::ThreadShortage::~ThreadShortage() = default;

bool innergs::test::ThreadShortage::known() {
  return false;
}
#endif
