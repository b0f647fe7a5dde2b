#include "CLI/Interrupt.h"

#include <atomic>
#include <chrono>
#include <csignal>

namespace innergs::cli {
namespace {

std::atomic<int> signalled = 0; // lock-free, so that a signal handler may set it

extern "C" void remember(int signal) {
  signalled = 1;
  std::signal(signal, SIG_DFL);
}

} // namespace

// A signal handler may do very little, so a thread passes on the request.
Interrupt::Interrupt()
    : watcher_([this](std::stop_token end) {
        while (!end.stop_requested() && !source_.stop_requested()) {
          if (signalled) source_.request_stop();
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
      }) {
  std::signal(SIGINT, remember);
  std::signal(SIGTERM, remember);
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

} // namespace innergs::cli
