#include "Microbenchmarks.h"

#include "Scene.h"

/// Micro-benchmarks of the engine; Google Benchmark's options apply, e.g. --benchmark_filter=gather.
int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::AddCustomContext("volume", innergs::bench::sceneName());
  innergs::bench::registerKernelBenchmarks();
  innergs::bench::registerFitBenchmarks();
  innergs::bench::registerRenderBenchmarks();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
