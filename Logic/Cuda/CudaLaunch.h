#pragma once
#include "Cuda/Kernels.h"

#include <cuda_runtime_api.h>

namespace innergs::cuda {

/// Code that only nvcc can compile, spread over several files that compile in parallel.
template <class Kernel>
cudaError_t launchOnDevice(const Kernel& kernel, unsigned blocks, cudaStream_t stream);

/// temporary = null: only returns the number of bytes needed.
cudaError_t scanOnDevice(void* temporary, std::size_t& bytes, const std::int64_t* in, std::int64_t* out,
                         std::int64_t count, cudaStream_t stream);
cudaError_t sortOnDevice(void* temporary, std::size_t& bytes, std::uint64_t*& keys, std::uint64_t*& otherKeys,
                         std::uint32_t*& ids, std::uint32_t*& otherIds, std::int64_t count, int bits,
                         cudaStream_t stream);

} // namespace innergs::cuda
