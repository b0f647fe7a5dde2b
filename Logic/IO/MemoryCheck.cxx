#include "IO/MemoryCheck.h"

#include "Core/Base/Error.h"
#include "Core/Base/Quantities.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

void checkMemoryFor(double bytes, const std::string& what) {
  const std::int64_t available = availableMemory();
  if (available == 0 || bytes <= static_cast<double>(available)) return;
  throw Error(ErrorCode::Memory, what + " needs " + bytesText(bytes) + " of memory, but only " +
                                     bytesText(static_cast<double>(available)) +
                                     " is available; crop it or lower its resolution.");
}

} // namespace innergs
