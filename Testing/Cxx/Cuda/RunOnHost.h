#pragma once
#include "Cuda/HostExecutor.h"

namespace innergs::cuda {

/// Runs a kernel as the host executor does, without another instantiation of all kernels.
template <class Kernel>
void runOnHost(const Kernel& kernel, std::int64_t blocks) {
  static const std::unique_ptr<Executor> host = makeHostExecutor();
  host->run(kernel, blocks);
}

} // namespace innergs::cuda
