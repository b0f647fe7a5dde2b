#pragma once
#include <functional>
#include <future>
#include <stop_token>

namespace innergs::mrml {

/// Runs foreign code that cannot be stopped, so that a stop need not wait for it. The code is then left
/// running, so it must own its data; the destructor waits for its end.
class DetachedTasks {
public:
  /// Returns what work returns, throws what it throws, or throws Error(Cancelled) as soon as a stop is
  /// requested. For one thread at a time; first waits for earlier work that was left running.
  bool run(std::function<bool()> work, const std::stop_token& stop);

private:
  std::future<bool> left_;
};

} // namespace innergs::mrml
