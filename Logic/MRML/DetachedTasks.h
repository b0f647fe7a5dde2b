#pragma once
#include <functional>
#include <future>
#include <stop_token>

namespace innergs::mrml {

/// Runs what cannot be stopped (others' code) so that a stop need not wait for it: left to itself then, it
/// must own what it works on, and its end is waited for with that of this object.
class DetachedTasks {
public:
  /// Returns what work returns, throws what it throws, or Error(Cancelled) as soon as a stop is asked for. By
  /// one thread at a time; what was left before is waited for first.
  bool run(std::function<bool()> work, const std::stop_token& stop);

private:
  std::future<bool> left_;
};

} // namespace innergs::mrml
