#include "Cuda/CudaExecutor.h"

#include "Core/Base/Error.h"
#include "Cuda/CudaLaunch.h"

#include <algorithm>
#include <limits>

namespace innergs::cuda {
namespace {

constexpr int kOldest = 75; // oldest compute capability that the kernels are built for, 10·major + minor

template <class Base, class... Kernels>
class CudaLaunches;

template <class Base>
class CudaLaunches<Base> : public Base {
protected:
  virtual void check(cudaError_t error) = 0;
  virtual void select() = 0;
  cudaStream_t stream_ = nullptr;
};

template <class Base, class Kernel, class... Others>
class CudaLaunches<Base, Kernel, Others...> : public CudaLaunches<Base, Others...> {
public:
  void launch(const Kernel& kernel, std::int64_t blocks) override {
    if (blocks > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::Memory, "The grid has too many tiles for the device: use the CPU.");
    this->select();
    this->check(launchOnDevice(kernel, static_cast<unsigned>(blocks), this->stream_));
  }
};

template <class List>
struct CudaBase;
template <class... Kernels>
struct CudaBase<KernelList<Kernels...>> {
  using Type = CudaLaunches<Executor, Kernels...>;
};

class CudaExecutor final : public CudaBase<AllKernels>::Type {
public:
  explicit CudaExecutor(int device) : device_(device) {
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device));
    name_ = properties.name;
    if (10 * properties.major + properties.minor < kOldest)
      throw Error(ErrorCode::InvalidArgument, "The device " + name_ +
                                                  " is too old: compute capability 7.5 or later is "
                                                  "needed; use the CPU.");
    select();
    int pools = 0;
    check(cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, device));
    if (pools) {
      check(cudaDeviceGetDefaultMemPool(&pool_, device));
      std::uint64_t keep = std::uint64_t{64} << 20; // for the small allocations of a query
      check(cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &keep));
    }
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking)); // last, so that no exception leaks it
  }
  ~CudaExecutor() override {
    if (cudaSetDevice(device_) != cudaSuccess) return;
    if (temporary_) release(temporary_);
    if (stream_) {
      cudaStreamSynchronize(stream_);
      cudaStreamDestroy(stream_);
    }
  }

  std::string name() const override { return name_; }

  std::size_t freeBytes() override {
    select();
    std::size_t free = 0, total = 0;
    check(cudaMemGetInfo(&free, &total));
    if (pool_) { // the pool holds these without using them
      std::uint64_t reserved = 0, used = 0;
      check(cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemCurrent, &reserved));
      check(cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrUsedMemCurrent, &used));
      free += static_cast<std::size_t>(reserved - used);
    }
    return free;
  }

  void* allocate(std::size_t bytes) override {
    select();
    void* memory = nullptr;
    if (!pool_) {
      check(cudaMalloc(&memory, bytes));
      return memory;
    }
    cudaError_t error = cudaMallocAsync(&memory, bytes, stream_);
    if (error == cudaErrorMemoryAllocation) { // freed memory may still be mapped in pieces
      cudaGetLastError();
      check(cudaStreamSynchronize(stream_));
      check(cudaMemPoolTrimTo(pool_, 0));
      error = cudaMallocAsync(&memory, bytes, stream_);
    }
    check(error);
    return memory;
  }
  void release(void* memory) noexcept override {
    cudaSetDevice(device_);
    if (pool_)
      cudaFreeAsync(memory, stream_);
    else
      cudaFree(memory);
  }
  void upload(void* to, const void* from, std::size_t bytes) override {
    select();
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_));
    check(cudaStreamSynchronize(stream_)); // pinned memory would be read later
  }
  void download(void* to, const void* from, std::size_t bytes) override {
    select();
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_));
    check(cudaStreamSynchronize(stream_));
  }
  void fill(void* memory, int byte, std::size_t bytes) override {
    select();
    check(cudaMemsetAsync(memory, byte, bytes, stream_));
  }

  void scan(const std::int64_t* in, std::int64_t* out, std::int64_t count) override {
    select();
    std::size_t bytes = 0;
    check(scanOnDevice(nullptr, bytes, in, out, count, stream_));
    void* temporary = temporaryOf(bytes);
    check(scanOnDevice(temporary, bytes, in, out, count, stream_));
  }
  void prepareSort(std::int64_t count, int bits) override {
    select();
    std::size_t scanning = 0, sorting = 0;
    std::uint64_t *keys = nullptr, *otherKeys = nullptr;
    std::uint32_t *ids = nullptr, *otherIds = nullptr;
    check(scanOnDevice(nullptr, scanning, nullptr, nullptr, count, stream_));
    check(sortOnDevice(nullptr, sorting, keys, otherKeys, ids, otherIds, count, bits, stream_));
    temporaryOf(std::max(scanning, sorting));
  }
  void sort(std::uint64_t*& keys, std::uint64_t*& otherKeys, std::uint32_t*& ids, std::uint32_t*& otherIds,
            std::int64_t count, int bits) override {
    select();
    std::size_t bytes = 0;
    check(sortOnDevice(nullptr, bytes, keys, otherKeys, ids, otherIds, count, bits, stream_));
    void* temporary = temporaryOf(bytes);
    check(sortOnDevice(temporary, bytes, keys, otherKeys, ids, otherIds, count, bits, stream_));
  }

  double seconds(const std::function<void()>& queued) {
    struct Event {
      cudaEvent_t event = nullptr;
      ~Event() {
        if (event) cudaEventDestroy(event);
      }
    } begin, end;
    select();
    check(cudaEventCreate(&begin.event));
    check(cudaEventCreate(&end.event));
    check(cudaEventRecord(begin.event, stream_));
    queued();
    check(cudaEventRecord(end.event, stream_));
    check(cudaEventSynchronize(end.event));
    float milliseconds = 0;
    check(cudaEventElapsedTime(&milliseconds, begin.event, end.event));
    return 1e-3 * static_cast<double>(milliseconds);
  }

private:
  void select() override { check(cudaSetDevice(device_)); }

  void check(cudaError_t error) override {
    if (error == cudaSuccess) return;
    cudaGetLastError(); // a non-fatal error must not be reported twice
    const std::string device = name_.empty() ? "CUDA device " + std::to_string(device_) : name_;
    if (error == cudaErrorMemoryAllocation)
      throw Error(ErrorCode::Memory, "The memory of " + device + " is full: use fewer Gaussians or the CPU.");
    throw Error(ErrorCode::Internal,
                device + " failed (" + cudaGetErrorString(error) + "): update the driver or use the CPU.");
  }

  void* temporaryOf(std::size_t bytes) {
    bytes = std::max<std::size_t>(bytes, 1);
    if (bytes > temporaryBytes_) {
      if (temporary_) release(temporary_);
      temporary_ = nullptr;
      temporaryBytes_ = 0;
      temporary_ = allocate(bytes);
      temporaryBytes_ = bytes;
    }
    return temporary_;
  }

  int device_;
  std::string name_;
  cudaMemPool_t pool_ = nullptr;
  void* temporary_ = nullptr; // of scan and sort
  std::size_t temporaryBytes_ = 0;
};

} // namespace

DeviceList cudaDevices() {
  DeviceList list;
  try {
    int driver = 0, count = 0;
    if (cudaDriverGetVersion(&driver) != cudaSuccess || driver == 0) {
      list.problem = "No NVIDIA driver is installed.";
      return list;
    }
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error != cudaSuccess) {
      cudaGetLastError();
      list.problem = error == cudaErrorInsufficientDriver
                         ? "The NVIDIA driver is too old for this program: update it."
                     : error == cudaErrorNoDevice
                         ? "No CUDA device is present."
                         : std::string("The NVIDIA driver failed: ") + cudaGetErrorString(error) + ".";
      return list;
    }
    for (int d = 0; d < count; ++d) {
      DeviceInfo info;
      cudaDeviceProp properties;
      if (cudaGetDeviceProperties(&properties, d) == cudaSuccess) {
        info.name = properties.name;
        info.computeCapability = std::to_string(properties.major) + "." + std::to_string(properties.minor);
        info.totalMemory = static_cast<std::int64_t>(properties.totalGlobalMem);
      }
      cudaGetLastError();
      list.devices.push_back(std::move(info));
    }
    if (list.devices.empty()) list.problem = "No CUDA device is present.";
  } catch (const std::exception& error) {
    list.devices.clear();
    list.problem = error.what();
  }
  return list;
}

std::int64_t cudaFreeMemory(int device) {
  std::size_t free = 0, total = 0;
  cudaError_t error = cudaSetDevice(device);
  if (error == cudaSuccess) error = cudaMemGetInfo(&free, &total);
  if (error != cudaSuccess) {
    cudaGetLastError();
    throw Error(ErrorCode::Internal, "CUDA device " + std::to_string(device) + " failed (" +
                                         cudaGetErrorString(error) + "): update the driver or use the CPU.");
  }
  return static_cast<std::int64_t>(free);
}

CudaFacts cudaFacts(int device) {
  CudaFacts facts;
  facts.free = cudaFreeMemory(device);
  const auto attribute = [&](cudaDeviceAttr which) {
    int value = 0;
    if (cudaDeviceGetAttribute(&value, which, device) != cudaSuccess) cudaGetLastError();
    return value;
  };
  cudaDriverGetVersion(&facts.driver);
  cudaRuntimeGetVersion(&facts.runtime);
  facts.processors = attribute(cudaDevAttrMultiProcessorCount);
  const int capability =
      10 * attribute(cudaDevAttrComputeCapabilityMajor) + attribute(cudaDevAttrComputeCapabilityMinor);
  facts.lanes = capability > 80 ? 128 : 64;
  facts.hertz = 1e3 * attribute(cudaDevAttrClockRate);
  facts.bytesPerSecond =
      2e3 * attribute(cudaDevAttrMemoryClockRate) * attribute(cudaDevAttrGlobalMemoryBusWidth) / 8;
  std::size_t free = 0, total = 0;
  if (cudaMemGetInfo(&free, &total) == cudaSuccess) facts.memory = static_cast<std::int64_t>(total);
  cudaMemPool_t pool = nullptr;
  std::uint64_t now = 0, most = 0, reset = 0;
  if (attribute(cudaDevAttrMemoryPoolsSupported) &&
      cudaDeviceGetDefaultMemPool(&pool, device) == cudaSuccess &&
      cudaMemPoolGetAttribute(pool, cudaMemPoolAttrReservedMemCurrent, &now) == cudaSuccess &&
      cudaMemPoolGetAttribute(pool, cudaMemPoolAttrReservedMemHigh, &most) == cudaSuccess)
    cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReservedMemHigh, &reset);
  facts.reserved = static_cast<std::int64_t>(now);
  facts.highest = static_cast<std::int64_t>(most);
  cudaGetLastError();
  return facts;
}

double cudaSeconds(Executor& executor, const std::function<void()>& queued) {
  return dynamic_cast<CudaExecutor&>(executor).seconds(queued);
}

std::unique_ptr<Executor> makeCudaExecutor(int device) {
  const DeviceList list = cudaDevices();
  if (list.devices.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no CUDA device. " + list.problem);
  if (device < 0 || device >= static_cast<int>(list.devices.size()))
    throw Error(ErrorCode::InvalidArgument, "There is no device cuda:" + std::to_string(device) +
                                                ": choose one from 0 to " +
                                                std::to_string(list.devices.size() - 1) + ".");
  return std::make_unique<CudaExecutor>(device);
}

} // namespace innergs::cuda
