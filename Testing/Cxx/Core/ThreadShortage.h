#pragma once

namespace innergs::test {

/// While it lives, the system refuses to start more threads than `allowed` at a time. Where such a
/// system cannot be acted (known() is false), it changes nothing. Link ThreadShortage.cxx.
class ThreadShortage {
public:
  explicit ThreadShortage(int allowed);
  ~ThreadShortage();
  ThreadShortage(const ThreadShortage&) = delete;
  ThreadShortage& operator=(const ThreadShortage&) = delete;

  static bool known();
};

} // namespace innergs::test
