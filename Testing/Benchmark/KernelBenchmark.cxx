#include "Microbenchmarks.h"
#include "Scene.h"

#include "Core/Base/Random.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Tiles.h"

#include <cmath>

namespace innergs::bench {
namespace {

/// The scene projected onto its grid and binned, with work buffers; one thread.
struct KernelScene {
  KernelScene() : pool(1), grid(sceneGrid()), tiles(view()) {
    project(scene().field, {}, grid, {}, pool, projected);
    tiles.bin(projected, view(), pool);
    weights.assign(grid.bufferSize(), 0.f);
    numerators = weights;
    Random random(1);
    for (std::size_t row = 0; row < grid.bufferSize(); row += grid.stride())
      for (int x = 0; x < grid.nx; ++x) {
        weights[row + x] = static_cast<float>(random.uniform() - 0.5);
        numerators[row + x] = static_cast<float>(random.uniform() - 0.5);
      }
    pairs = countPairs();
  }

  GridView view() const { return {grid.nx, grid.ny, grid.planes(), grid.stride(), grid.z.data()}; }

  /// (Gaussian, voxel) pairs inside the cut-off, by the scalar kernel: with F0 = 1 and unit weights, its
  /// moment n0 is Σ(p − cut), so lowering the cut by 1 adds 1 per voxel.
  double countPairs() const {
    const std::vector<float> ones(grid.bufferSize(), 1.f), zeros(grid.bufferSize(), 0.f);
    const KernelSet& scalar = kernelSet("scalar");
    double total = 0;
    for (Projected g : projected) {
      g.log2Cut -= g.log2Weight;
      g.log2Weight = 0;
      math::Moments<float> without, with;
      g.cut = 0;
      scalar.gather(g, view(), ones.data(), zeros.data(), without);
      g.cut = -1;
      scalar.gather(g, view(), ones.data(), zeros.data(), with);
      total += std::round(static_cast<double>(with.n0) - without.n0);
    }
    return total;
  }

  ThreadPool pool;
  SampleGrid grid;
  Tiles tiles;
  std::vector<Projected> projected;
  std::vector<float> weights, numerators;
  double pairs = 0;
};

KernelScene& kernelScene() {
  static KernelScene made;
  return made;
}

void count(benchmark::State& state, double pairs) {
  state.counters["pairs"] = pairs;
  state.counters["pairs_per_second"] =
      benchmark::Counter(pairs, benchmark::Counter::kIsIterationInvariantRate);
}

void accumulate(benchmark::State& state, const KernelSet& kernels) {
  KernelScene& s = kernelScene();
  const GridView grid = s.view();
  std::vector<float> weights(s.weights.size(), 0.f), numerators(weights);
  for (auto _ : state) {
    for (std::int64_t t = 0; t < s.tiles.count(); ++t) {
      const auto members = s.tiles.members(t);
      kernels.accumulate(s.projected.data(), members.data(), members.size(), grid, s.tiles.range(t, grid),
                         weights.data(), numerators.data());
    }
    benchmark::ClobberMemory();
  }
  count(state, s.pairs);
}

void gather(benchmark::State& state, const KernelSet& kernels) {
  KernelScene& s = kernelScene();
  const GridView grid = s.view();
  for (auto _ : state)
    for (const Projected& g : s.projected) {
      math::Moments<float> moments;
      kernels.gather(g, grid, s.weights.data(), s.numerators.data(), moments);
      benchmark::DoNotOptimize(moments);
    }
  count(state, s.pairs);
}

} // namespace

void registerKernelBenchmarks() {
  for (const KernelSet& set : kernelSets()) {
    steady(benchmark::RegisterBenchmark(("forward/" + set.name).c_str(), accumulate, set));
    steady(benchmark::RegisterBenchmark(("backward/" + set.name).c_str(), gather, set));
  }
}

} // namespace innergs::bench
