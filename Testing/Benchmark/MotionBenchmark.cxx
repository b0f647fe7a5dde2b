#include "Microbenchmarks.h"

#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/DynamicSampler.h"

#include <cmath>

namespace innergs::bench {
namespace {

constexpr int kPixels = 512; // a side of the plane

/// Two blobs that swing: 64×64×12 voxels, 12 frames, as much as a wrist's.
TimeSeries swinging() {
  TimeSeries series;
  series.geometry.size = {64, 64, 12};
  series.geometry.spacing = {1.5, 1.5, 4};
  for (int f = 0; f < 12; ++f) {
    auto& frame = series.frames.emplace_back();
    const double shift = 8 * std::sin(0.4 * f);
    for (int k = 0; k < 12; ++k)
      for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i) {
          const double x = i - 32 - shift, y = j - 32, z = 2.5 * (k - 6);
          frame.push_back(static_cast<float>(
              10 + 100 * std::exp(-(x * x + y * y + z * z) / 200) +
              60 * std::exp(-((x - 14) * (x - 14) + (y + 9) * (y + 9) + z * z) / 40) * (1.2 + std::sin(i))));
        }
    series.times.push_back(0.5 * f);
  }
  return series;
}

/// 42,875 Gaussians (the paper's 35³), carried; fitted once, roughly: the work of a query is the same.
std::shared_ptr<const DynamicField> dynamicField() {
  static const std::shared_ptr<const DynamicField> once = [] {
    Settings settings;
    settings.kind = DynamicKind::Motion;
    settings.gaussians = 35 * 35 * 35;
    settings.rounds = 1;
    return DynamicJob(swinging(), settings).run().field;
  }();
  return once;
}

/// An oblique plane that turns from call to call, and its time.
void planeAt(benchmark::State& state) {
  static DynamicSampler sampler(dynamicField());
  static int calls = 0;
  std::vector<float> pixels(std::size_t{kPixels} * kPixels);
  for (auto _ : state) {
    const double angle = 0.3 + 0.05 * (++calls % 40), pixel = 110. / kPixels;
    const double c = std::cos(angle), s = std::sin(angle);
    Affine3 plane;
    plane.linear[0] = {pixel * c, 0, 0};
    plane.linear[1] = {0, pixel, 0};
    plane.linear[2] = {pixel * s, 0, 1};
    plane.offset = {47 - 55 * c, 47 - 55, 22 - 55 * s};
    const double time = state.range(0) == 0 ? 2.2 : std::fmod(0.37 * calls, 5.5);
    sampler.sample(plane, time, kPixels, kPixels, pixels);
    benchmark::DoNotOptimize(pixels.data());
  }
}

} // namespace

void registerMotionBenchmarks() {
  benchmark::RegisterBenchmark("moving_plane", planeAt)
      ->ArgName("new_time")
      ->Arg(0)
      ->Arg(1)
      ->Iterations(1)
      ->Repetitions(51)
      ->ReportAggregatesOnly(true)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

} // namespace innergs::bench
