#pragma once

namespace innergs {

/// Lowers the calling thread's priority for good, and that of any ThreadPool it creates. Use it for work
/// started from a user interface: on an idle machine it runs as fast as before.
/// Does nothing if the system refuses.
void lowerThreadPriority();

/// Whether the calling thread has called lowerThreadPriority().
bool threadPriorityLowered();

} // namespace innergs
