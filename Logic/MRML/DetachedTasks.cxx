#include "DetachedTasks.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"

#include <chrono>
#include <system_error>

namespace innergs::mrml {

namespace {

bool isOver(const std::future<bool>& done, std::chrono::milliseconds patience) {
  return done.wait_for(patience) == std::future_status::ready;
}

} // namespace

bool DetachedTasks::run(std::function<bool()> work, const std::stop_token& stop) {
  const auto wait = [&](const std::future<bool>& done) {
    while (!isOver(done, std::chrono::milliseconds(stop.stop_requested() ? 0 : 10)))
      throwIfStopped(stop);
  };
  throwIfStopped(stop);
  if (left_.valid()) wait(left_); // one at a time: many would take all cores from later ones
  std::future<bool> done;
  try {
    done = std::async(std::launch::async, work);
  } catch (const std::system_error&) { // no more threads available
    return work();
  }
  try {
    wait(done);
  } catch (const Error&) {
    left_ = std::move(done);
    throw;
  }
  return done.get();
}

} // namespace innergs::mrml
