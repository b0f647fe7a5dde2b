// Speed of a CUDA device: sweeps, plane queries, and the two heaviest kernels beside what the device could
// do.
#include "Core/Candidates.h"
#include "Core/Stack.h"
#include "Cuda/CudaExecutor.h"
#include "Cuda/Field.h"
#include "Cuda/Fit.h"

#include <benchmark/benchmark.h>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cuda_runtime_api.h>

namespace {

using namespace innergs;
using cuda::Buffer;

/// A smooth synthetic volume, and Gaussians on an even grid of edge³ with σ half their spacing.
struct Scene {
  Stack stack;
  GaussianField field;

  Scene(std::int64_t nx, std::int64_t ny, std::int64_t nz, int edge, Blending blending, bool linear) {
    stack.image.geometry.size = {nx, ny, nz};
    stack.profile = SliceProfile::Point;
    for (std::int64_t k = 0; k < nz; ++k)
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = 0; i < nx; ++i)
          stack.image.voxels.push_back(static_cast<float>(
              0.5 + 0.3 * std::sin(0.21 * static_cast<double>(i)) * std::cos(0.17 * static_cast<double>(j)) +
              0.1 * std::sin(0.3 * static_cast<double>(k))));
    field.blending = blending;
    field.linearIntensity = linear;
    field.cutoff = 2.2;
    const double spacing[3] = {static_cast<double>(nx) / edge, static_cast<double>(ny) / edge,
                               static_cast<double>(nz) / edge};
    for (int k = 0; k < edge; ++k)
      for (int j = 0; j < edge; ++j)
        for (int i = 0; i < edge; ++i) {
          Gaussian g{};
          const int at[3] = {i, j, k};
          for (int a = 0; a < 3; ++a) {
            g.mean[a] = static_cast<float>((at[a] + 0.5) * spacing[a] - 0.5);
            g.logScale[a] = static_cast<float>(std::log(0.5 * spacing[a]));
          }
          g.quaternion[0] = 1;
          g.intensity = 0.5f;
          g.logWeight = blending == Blending::Alpha ? 0.f : -0.1f;
          field.gaussians.push_back(g);
        }
  }
  std::vector<Observation> observations() const { return observe(stack, {}, {}, false); }
};

Scene brain(Blending blending) {
  return {145, 174, 145, 42, blending, blending == Blending::Normalised};
}

/// Runs of sweeps with one wait, as jobs do them; relocation after every `relocateEvery` (0: never).
void sweeps(benchmark::State& state, const Scene& scene, int relocateEvery = 0) {
  constexpr int kRun = 20;
  FitRequest request;
  request.observations = std::make_shared<const std::vector<Observation>>(scene.observations());
  request.blending = scene.field.blending;
  request.linearIntensity = scene.field.linearIntensity;
  request.gaussians = scene.field.size();
  request.rules.bounds = {std::log(0.2), std::log(30)};
  cuda::Fit fit(cuda::makeCudaExecutor(0), request);
  const std::size_t before = fit.executor().freeBytes();
  fit.upload(scene.field, Adam(scene.field.size()), {});
  std::vector<SweepOrder> orders(kRun);
  int step = 0;
  const auto run = [&] {
    for (SweepOrder& order : orders) {
      order.rates = {0.02, 0.009, 0.009, 0.015, 0.003, 0.001};
      order.step = ++step;
      if (relocateEvery > 0 && step % relocateEvery == 0)
        order.relocate = RelocationPlan{0.02, request.rules.bounds.minLogScale};
      else
        order.relocate.reset();
    }
    for (std::size_t done = 0; done < orders.size();)
      done += fit.sweeps(std::span(orders).subspan(done)).size();
  };
  run();
  for (auto _ : state)
    run();
  using benchmark::Counter;
  state.counters["seconds_a_sweep"] = Counter(kRun, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["MiB_of_sweep"] = static_cast<double>(before - fit.executor().freeBytes()) / (1 << 20);
}

void sweepNormalised(benchmark::State& state) {
  sweeps(state, brain(Blending::Normalised));
}
void sweepRelocating(benchmark::State& state) {
  sweeps(state, brain(Blending::Normalised), 5);
}
void sweepAdditive(benchmark::State& state) {
  sweeps(state, brain(Blending::Additive));
}
void sweepAlpha(benchmark::State& state) {
  sweeps(state, brain(Blending::Alpha));
}
void sweepLarge(benchmark::State& state) {
  sweeps(state, {512, 512, 512, 126, Blending::Normalised, false});
}

void obliquePlane(benchmark::State& state) {
  const Scene scene = brain(Blending::Normalised);
  cuda::Field field(cuda::makeCudaExecutor(0), scene.field);
  Lattice lattice;
  lattice.nx = lattice.ny = 512;
  lattice.z = {0};
  const double s = 0.35;
  lattice.indexToModel.linear = {
      {{{0.8 * s, -0.36 * s, 0.48}, {0.6 * s, 0.48 * s, -0.64}, {0, 0.8 * s, 0.6}}}};
  lattice.indexToModel.offset = {30, 10, 10};
  std::vector<float> out(512 * 512);
  for (auto _ : state) {
    field.renderLattice(lattice, {}, {}, out.data(), {});
    benchmark::DoNotOptimize(out.data());
  }
}

/// The pieces of a sweep up to one kernel, which is then run by itself.
struct Bench {
  std::unique_ptr<cuda::Executor> executor = cuda::makeCudaExecutor(0);
  Scene scene = brain(Blending::Normalised);
  Observation observation = scene.observations().at(0);
  std::int64_t count = scene.field.size(), pairs = 0;
  cuda::DevicePlanes planes{*executor, observation.lattice, 0, observation.lattice.planes()};
  cuda::BrickReach bricks = cuda::bricksOf(planes.view());
  Buffer<Gaussian> gaussians{*executor};
  Buffer<Projected> projected{*executor};
  Buffer<std::int64_t> counts{*executor}, first{*executor}, start{*executor};
  Buffer<std::uint64_t> keys{*executor}, otherKeys{*executor};
  Buffer<std::uint32_t> ids{*executor}, otherIds{*executor};
  Buffer<cuda::Pair> out{*executor};
  Buffer<math::Moments<float>> moments{*executor};
  Buffer<cuda::SweepStatus> status{*executor};

  Bench() {
    gaussians.upload(scene.field.gaussians.data(), count);
    projected.reserve(count);
    counts.reserve(count + 1);
    first.reserve(count + 1);
    status.reserve(1);
    status.fill(0, 1);
    const ProjectionRules rules{static_cast<float>(scene.field.cutoff * scene.field.cutoff),
                                scene.field.blending,
                                scene.field.linearIntensity,
                                Selection::Exact,
                                {}};
    executor->runOver(cuda::Project{gaussians.data(), nullptr, count, projectionFrame(observation.lattice),
                                    rules, projected.data()},
                      count);
    executor->runOver(cuda::CountPairs<cuda::BrickReach>{projected.data(), count, bricks, counts.data()},
                      count + 1);
    executor->scan(counts.data(), first.data(), count + 1);
    executor->download(&pairs, first.data() + count, sizeof pairs);
    keys.reserve(pairs);
    otherKeys.reserve(pairs);
    ids.reserve(pairs);
    otherIds.reserve(pairs);
    start.reserve(bricks.count() + 1);
    executor->runOver(cuda::EmitPairs<cuda::BrickReach>{projected.data(), count, bricks, first.data(), pairs,
                                                        keys.data(), ids.data(), nullptr, status.data()},
                      count + 1);
    cuda::sortPairs(*executor, keys, otherKeys, ids, otherIds, pairs,
                    std::bit_width(static_cast<std::uint64_t>(bricks.count())));
    executor->runOver(cuda::FindStarts{keys.data(), pairs, bricks.count(), 0, start.data()},
                      bricks.count() + 1);
    out.reserve(static_cast<std::int64_t>(observation.lattice.bufferSize()));
    out.fill(0, out.size());
    moments.reserve(count);
  }

  void wait() {
    std::int64_t ignored;
    executor->download(&ignored, status.data(), sizeof ignored);
  }

  /// Points that lie in the Gaussians' ellipsoids: what has to be computed at least.
  double evaluations() const {
    ThreadPool pool;
    std::vector<Projected> host;
    project(scene.field, {}, observation.lattice, {}, pool, host);
    const Lattice& l = observation.lattice;
    const LatticeView view{l.nx, l.ny, l.planes(), l.stride(), l.z.data()};
    double n = 0;
    for (const Projected& g : host)
      forEachCandidateRow<Selection::Exact>(g, view, {0, l.ny, 0, l.planes()},
                                            [&](int, int, int x0, int x1) { n += x1 - x0; });
    return n;
  }

  /// flops and bytes: of one run, the least that the method allows.
  void report(benchmark::State& state, double evaluations, double flops, double bytes) const {
    int processors = 0, kilohertz = 0, memoryKilohertz = 0, bits = 0, major = 0, minor = 0;
    cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, 0);
    cudaDeviceGetAttribute(&kilohertz, cudaDevAttrClockRate, 0);
    cudaDeviceGetAttribute(&memoryKilohertz, cudaDevAttrMemoryClockRate, 0);
    cudaDeviceGetAttribute(&bits, cudaDevAttrGlobalMemoryBusWidth, 0);
    cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, 0);
    cudaDeviceGetAttribute(&minor, cudaDevAttrComputeCapabilityMinor, 0);
    const int lanes =
        major > 8 || (major == 8 && minor > 0) ? 128 : 64; // single-precision units of a processor
    const double peakFlops = 2.0 * lanes * processors * kilohertz * 1e3,
                 peakBytes = 2.0 * memoryKilohertz * 1e3 * bits / 8;
    using benchmark::Counter;
    const auto rate = Counter::kIsIterationInvariantRate;
    state.counters["evaluations/s"] = Counter(evaluations, rate);
    state.counters["of_arithmetic_limit"] = Counter(flops / peakFlops, rate);
    state.counters["of_bandwidth_limit"] = Counter(bytes / peakBytes, rate);
  }
};

constexpr int kRepeats = 50; // of a kernel between two waits

void accumulateKernel(benchmark::State& state) {
  Bench bench;
  const double n = bench.evaluations();
  for (auto _ : state) {
    for (int i = 0; i < kRepeats; ++i)
      bench.executor->run(cuda::Accumulate{bench.projected.data(), bench.bricks, bench.start.data(),
                                           bench.ids.data(), bench.out.data()},
                          bench.bricks.count());
    bench.wait();
  }
  const double points = static_cast<double>(bench.observation.lattice.bufferSize());
  // An exponent of 2 multiply-adds in a column, the exponential, and 4 more: 14 operations.
  bench.report(state, kRepeats * n, kRepeats * n * 14,
               kRepeats * (8 * points + 116.0 * static_cast<double>(bench.pairs)));
}

void gatherKernel(benchmark::State& state) {
  Bench bench;
  const double n = bench.evaluations();
  for (auto _ : state) {
    for (int i = 0; i < kRepeats; ++i)
      bench.executor->run(cuda::Gather{bench.projected.data(),
                                       bench.count,
                                       {bench.planes.view(), bench.out.data()},
                                       bench.moments.data(),
                                       false},
                          cuda::blocksFor(bench.count, cuda::Gather::kWarps));
    bench.wait();
  }
  const double points = static_cast<double>(bench.observation.lattice.bufferSize());
  // Exponent, exponential, value and six sums: 24 operations.
  bench.report(state, kRepeats * n, kRepeats * n * 24,
               kRepeats * (8 * points + 168.0 * static_cast<double>(bench.count)));
}

BENCHMARK(sweepNormalised)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(sweepRelocating)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(sweepAdditive)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(sweepAlpha)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(sweepLarge)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(obliquePlane)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(accumulateKernel)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(gatherKernel)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace

int main(int argc, char** argv) {
  const DeviceList list = cuda::cudaDevices();
  if (list.devices.empty()) {
    std::printf("NOTHING MEASURED: %s\n", list.problem.c_str());
    return 0;
  }
  const DeviceInfo& device = list.devices.front();
  std::printf("Device: %s, compute capability %s, %.1f GiB. Normalised 145x174x145 with 74,088 Gaussians; "
              "sweepLarge: "
              "512x512x512 with 2,000,376.\n",
              device.name.c_str(), device.computeCapability.c_str(),
              static_cast<double>(device.totalMemory) / (1 << 30));
  benchmark::AddCustomContext("device", device.name);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
