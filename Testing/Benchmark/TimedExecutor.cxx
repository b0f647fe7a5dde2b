#include "TimedExecutor.h"

#ifdef INNERGS_BENCHMARK_CUDA
#include "Cuda/CudaExecutor.h"
#endif

#include <chrono>
#include <cstdlib>
#if defined(__GNUG__)
#include <cxxabi.h>
#endif

namespace innergs::bench {

double secondsOf(cuda::Executor& executor, const std::function<void()>& queued) {
#ifdef INNERGS_BENCHMARK_CUDA
  if (executor.name() != "host") return cuda::cudaSeconds(executor, queued);
#endif
  const auto start = std::chrono::steady_clock::now();
  queued();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string plainName(const std::type_info& type) {
  std::string name = type.name();
#if defined(__GNUG__)
  if (char* plain = abi::__cxa_demangle(type.name(), nullptr, nullptr, nullptr)) {
    name = plain;
    std::free(plain);
  }
#endif
  const std::string scope = "innergs::cuda::";
  for (std::size_t at; (at = name.find(scope)) != std::string::npos;)
    name.erase(at, scope.size());
  return name;
}

} // namespace innergs::bench
