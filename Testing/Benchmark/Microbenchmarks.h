#pragma once
#include <benchmark/benchmark.h>

namespace innergs::bench {

void registerKernelBenchmarks();
void registerFitBenchmarks();
void registerRenderBenchmarks();
void registerMotionBenchmarks();
void registerNetworkBenchmarks();
void registerVTKBenchmarks(); // if VTK is found

/// Short repetitions, reported as median and spread, so that one disturbed repetition does not matter.
inline benchmark::internal::Benchmark* steady(benchmark::internal::Benchmark* b) {
  return b->MinTime(0.2)->Repetitions(5)->ReportAggregatesOnly(true)->Unit(benchmark::kMillisecond);
}

} // namespace innergs::bench
