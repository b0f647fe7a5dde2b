#pragma once
#include <functional>
#include <future>
#include <stop_token>

namespace innergs::mrml {

/// Runs others' code, which cannot be stopped, so that a stop need not wait for it. It is left to itself
/// then, so it must own what it works on; the destructor waits for its end.
class DetachedTasks {
public:
  /// Returns what work returns, throws what it throws, or Error(Cancelled) as soon as a stop is requested.
  /// For one thread at a time; waits first for what was left to itself before.
  bool run(std::function<bool()> work, const std::stop_token& stop);

private:
  std::future<bool> left_;
};

} // namespace innergs::mrml
