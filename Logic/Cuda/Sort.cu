#include "Cuda/CudaLaunch.h"

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

namespace innergs::cuda {

cudaError_t scanOnDevice(void* temporary, std::size_t& bytes, const std::int64_t* in, std::int64_t* out,
                         std::int64_t count, cudaStream_t stream) {
  return cub::DeviceScan::ExclusiveSum(temporary, bytes, in, out, count, stream);
}

cudaError_t sortOnDevice(void* temporary, std::size_t& bytes, std::uint64_t*& keys, std::uint64_t*& otherKeys,
                         std::uint32_t*& ids, std::uint32_t*& otherIds, std::int64_t count, int bits,
                         cudaStream_t stream) {
  cub::DoubleBuffer<std::uint64_t> k(keys, otherKeys);
  cub::DoubleBuffer<std::uint32_t> v(ids, otherIds);
  // Passes and Reshape have fewer than 2³² elements; 32-bit counts let CUB use 32-bit offsets.
  const cudaError_t error = cub::DeviceRadixSort::SortPairs(
      temporary, bytes, k, v, static_cast<std::uint32_t>(count), 0, bits, stream);
  if (temporary) {
    keys = k.Current();
    otherKeys = k.Alternate();
    ids = v.Current();
    otherIds = v.Alternate();
  }
  return error;
}

} // namespace innergs::cuda
