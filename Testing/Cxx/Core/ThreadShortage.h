#pragma once

namespace innergs::test {

/// While it lives, the system refuses to start more than `allowed` threads at a time. Does nothing where that
/// cannot be simulated (known() is false). Link ThreadShortage.cxx.
class ThreadShortage {
public:
  explicit ThreadShortage(int allowed);
  ~ThreadShortage();
  ThreadShortage(const ThreadShortage&) = delete;
  ThreadShortage& operator=(const ThreadShortage&) = delete;

  static bool known();
};

} // namespace innergs::test
