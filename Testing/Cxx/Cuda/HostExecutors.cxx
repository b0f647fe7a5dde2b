#include "Executors.h"
#include "RoundingExecutor.h"
#include "ThreadBlock.h"

#include <cstdlib>

namespace innergs::testing {

std::unique_ptr<cuda::Executor> makeThreadExecutor() {
  return std::make_unique<cuda::HostExecutor<RealThreads>>(std::size_t{1} << 40);
}

std::unique_ptr<cuda::Executor> makeRoundingExecutor() {
  if (const char* seed = std::getenv("INNERGS_SEED")) // other seeds on request
    cuda::Rounding::random = static_cast<std::uint32_t>(std::atoi(seed));
  return std::make_unique<cuda::HostExecutor<cuda::Rounding>>(std::size_t{1} << 40);
}

} // namespace innergs::testing
