#include "IO/MemoryCheck.h"

#include "Core/Error.h"
#include "Core/NumberText.h"
#include "Core/ReconstructionJob.h"

namespace innergs {

void checkMemoryFor(double bytes, const std::string& what) {
  const std::int64_t available = availableMemory();
  if (available == 0 || bytes <= static_cast<double>(available)) return;
  throw Error(
      ErrorCode::Memory,
      what + formatted(" needs %.1f GB of memory and %.1f GB are available; crop it or lower its resolution.",
                       bytes / 1e9, static_cast<double>(available) / 1e9));
}

} // namespace innergs
