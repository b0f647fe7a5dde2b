#pragma once
#include <atomic>
#include <stop_token>
#include <thread>

namespace innergs::cli {

/// While it lives, the first Ctrl-C (SIGINT) or SIGTERM requests a stop; a second one ends the program
/// immediately.
class Interrupt {
public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return source_.get_token(); }
  bool requested() const { return source_.stop_requested(); }

private:
  std::stop_source source_;
  std::jthread watcher_;
};

} // namespace innergs::cli
