#pragma once
#include "Core/Base/Error.h"

#include <stop_token>

namespace innergs {

/// Throws Error(Cancelled) if a stop was requested.
inline void throwIfStopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "Stopped on request.");
}

} // namespace innergs
