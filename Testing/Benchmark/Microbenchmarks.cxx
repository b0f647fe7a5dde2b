#include "Microbenchmarks.h"

#include "Scene.h"

#include <cstdlib>

/// Micro-benchmarks of the engine. The volume: an argument, the environment variable
/// INNERGS_BENCHMARK_VOLUME, or synthetic. Google Benchmark's options, e.g. --benchmark_filter=backward.
int main(int argc, char** argv) {
  if (const char* path = std::getenv("INNERGS_BENCHMARK_VOLUME")) innergs::bench::setSceneVolume(path);
  benchmark::Initialize(&argc, argv);
  if (argc == 2 && argv[1][0] != '-') {
    innergs::bench::setSceneVolume(argv[1]);
    argc = 1;
  }
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::AddCustomContext("volume", innergs::bench::sceneName());
  innergs::bench::registerKernelBenchmarks();
  innergs::bench::registerFitBenchmarks();
  innergs::bench::registerRenderBenchmarks();
  innergs::bench::registerMotionBenchmarks();
  innergs::bench::registerNetworkBenchmarks();
#ifdef INNERGS_BENCHMARK_VTK
  innergs::bench::registerVTKBenchmarks();
#endif
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
