#include "Microbenchmarks.h"
#include "Scene.h"

#include "Core/Base/Random.h"
#include "Core/Fit/Initialise.h"
#include "Core/Fit/Trainer.h"
#include "Core/Job/TimeEstimate.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Tiles.h"

namespace innergs::bench {
namespace {

/// Forward, loss, gradients and Adam over the slices of `axes` axes. Learning rates of 0 keep the field, so
/// every iteration costs the same.
void iterateOver(benchmark::State& state, const Scene& s, int axes, int threads) {
  ThreadPool pool(threads);
  FitPlan plan;
  plan.linearIntensity = s.field.linearIntensity;
  plan.iterations = 1 << 30;
  plan.cutoff = s.field.cutoff;
  std::vector<Observation> observations;
  for (int axis = 2; axis > 2 - axes; --axis)
    for (Observation& o : observe(withSliceAxis(s.stack, axis), s.field.modelToWorld, s.map, false))
      observations.push_back(std::move(o));
  Trainer trainer(s.field, std::move(observations), plan, kernelSet(""), pool);
  for (auto _ : state)
    trainer.step();
  state.counters["dB_fitted"] = -10 * std::log10(trainer.mse());
}

void iterate(benchmark::State& state) {
  iterateOver(state, scene(), 1, static_cast<int>(state.range(0)));
}

void alphaIteration(benchmark::State& state) {
  iterateOver(state, alphaScene(), static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

void adamStep(benchmark::State& state) {
  ThreadPool pool(1);
  GaussianField field = scene().field;
  Adam adam(field.size());
  Random random(1);
  std::vector<float> gradient(16 * field.gaussians.size());
  for (float& g : gradient)
    g = static_cast<float>(random.uniform() - 0.5);
  int step = 0;
  for (auto _ : state)
    adam.apply(field, gradient, {1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9}, {}, ++step, pool);
}

void projection(benchmark::State& state) {
  ThreadPool pool(1);
  const SampleGrid grid = sceneGrid();
  std::vector<Projected> projected;
  for (auto _ : state)
    project(scene().field, {}, grid, {}, pool, projected);
}

void binning(benchmark::State& state) {
  ThreadPool pool(1);
  const SampleGrid grid = sceneGrid();
  const GridView view{grid.nx, grid.ny, grid.planes(), grid.stride(), grid.z.data()};
  std::vector<Projected> projected;
  project(scene().field, {}, grid, {}, pool, projected);
  Tiles tiles(view);
  for (auto _ : state)
    tiles.bin(projected, view, pool);
}

void initialisation(benchmark::State& state) {
  ThreadPool pool(static_cast<int>(state.range(0)));
  const Scene& s = scene();
  GaussianField field = s.field;
  InitialisationPlan plan;
  plan.gaussians = kPaperGaussians;
  for (auto _ : state) {
    const ProxyVolume proxy =
        makeProxy({&s.stack, 1}, field.modelToWorld, s.map, s.stack.image.geometry.spacing[0], pool);
    initialise(field, proxy, plan, 1, pool);
  }
}

/// A whole fit, with its predicted time.
void wholeFit(benchmark::State& state) {
  ReconstructionInput input;
  input.stacks = {scene().stack};
  Settings settings;
  settings.preset = Preset::Fast;
  settings.threads = 2;
  settings.device = "cpu";
  const double estimated = estimateSeconds(input, settings);
  double seconds = 0;
  for (auto _ : state)
    seconds = ReconstructionJob(input, settings).run().seconds;
  state.counters["estimated_over_real"] = estimated / seconds;
}

} // namespace

void registerFitBenchmarks() {
  steady(benchmark::RegisterBenchmark("iteration", iterate))
      ->ArgName("threads")
      ->Arg(1)
      ->Arg(2)
      ->UseRealTime();
  steady(benchmark::RegisterBenchmark("alpha_iteration", alphaIteration))
      ->ArgNames({"axes", "threads"})
      ->Args({1, 2})
      ->Args({3, 2})
      ->UseRealTime();
  benchmark::RegisterBenchmark("whole_fit", wholeFit)
      ->Iterations(1)
      ->Repetitions(3)
      ->ReportAggregatesOnly(true)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  steady(benchmark::RegisterBenchmark("adam", adamStep));
  steady(benchmark::RegisterBenchmark("projection", projection));
  steady(benchmark::RegisterBenchmark("binning", binning));
  steady(benchmark::RegisterBenchmark("initialisation", initialisation))
      ->ArgName("threads")
      ->Arg(1)
      ->Arg(2)
      ->UseRealTime();
}

} // namespace innergs::bench
