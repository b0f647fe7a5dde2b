#pragma once

namespace innergs {

/// Puts the calling thread behind those that draw and answer the user, for its rest; a ThreadPool that it
/// makes does the same. For work started from a user interface: on an idle machine it is as fast as before.
/// Where the system refuses, nothing changes.
void lowerThreadPriority();

/// Whether the calling thread has asked for it.
bool threadPriorityLowered();

} // namespace innergs
