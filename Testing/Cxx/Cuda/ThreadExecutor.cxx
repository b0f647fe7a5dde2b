#include "Executors.h"
#include "ThreadBlock.h"

namespace innergs::testing {

std::unique_ptr<cuda::Executor> makeThreadExecutor() {
  return std::make_unique<cuda::HostExecutor<RealThreads>>(std::size_t{1} << 40);
}

} // namespace innergs::testing
