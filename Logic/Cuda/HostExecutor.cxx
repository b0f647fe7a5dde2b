#include "Cuda/HostExecutor.h"

#include "Cuda/HostBlock.h"

namespace innergs::cuda {
namespace {

struct BlockAfterBlock {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    const auto shared = std::make_unique<typename Kernel::Shared>();
    for (std::int64_t i = 0; i < blocks; ++i) {
      HostBlock<Kernel::kThreads, typename Kernel::Shared> block(i, *shared);
      kernel(block);
    }
  }
};

} // namespace

std::unique_ptr<Executor> makeHostExecutor(std::size_t memory) {
  return std::make_unique<HostExecutor<BlockAfterBlock>>(memory);
}

void failAllocations(Executor& host, int nth, int count) {
  auto& executor = dynamic_cast<HostMemory&>(host);
  executor.toFailure_ = nth;
  executor.failing_ = count;
}

int allocationsToFailure(const Executor& host) {
  return dynamic_cast<const HostMemory&>(host).toFailure_;
}

int downloads(const Executor& host) {
  return dynamic_cast<const HostMemory&>(host).downloads_;
}

} // namespace innergs::cuda
