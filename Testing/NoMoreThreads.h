#pragma once
#if defined(__GLIBC__)
#include <cstddef>
#include <pthread.h>

/// While it lives no thread can be started: each would get a stack larger than any address space.
class NoMoreThreads {
public:
  NoMoreThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, std::size_t{1} << 62);
    works_ = pthread_setattr_default_np(&huge) == 0;
    pthread_attr_destroy(&huge);
  }
  ~NoMoreThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  NoMoreThreads(const NoMoreThreads&) = delete;
  NoMoreThreads& operator=(const NoMoreThreads&) = delete;
  bool works() const { return works_; }

private:
  pthread_attr_t before_;
  bool works_ = false;
};
#else
/// Only known how where glibc is.
class NoMoreThreads {
public:
  bool works() const { return false; }
};
#endif
