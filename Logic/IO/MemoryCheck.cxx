#include "IO/MemoryCheck.h"

#include "Core/Error.h"
#include "Core/ReconstructionJob.h"

#include <cstdio>

namespace innergs {

void checkMemoryFor(double bytes, const std::string& what) {
  const std::int64_t available = availableMemory();
  if (available == 0 || bytes <= static_cast<double>(available)) return;
  char sentence[120];
  std::snprintf(sentence, sizeof(sentence),
                " needs %.1f GB of memory and %.1f GB are available; crop it or lower its resolution.",
                bytes / 1e9, static_cast<double>(available) / 1e9);
  throw Error(ErrorCode::Memory, what + sentence);
}

} // namespace innergs
