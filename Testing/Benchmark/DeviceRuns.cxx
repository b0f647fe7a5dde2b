#include "DeviceRuns.h"

#include "Core/Fit/Plan.h"
#include "Core/Fit/Trainer.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Render/Kernels.h"
#include "Cuda/Field.h"
#include "Cuda/HostExecutor.h"
#ifdef INNERGS_BENCHMARK_CUDA
#include "Cuda/CudaExecutor.h"
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace innergs::bench {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}
double timed(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return since(start);
}

Stack stackOf(Volume volume) {
  Stack stack;
  stack.image = std::move(volume);
  stack.profile = SliceProfile::Point;
  stack.thickness = stack.image.geometry.spacing[2];
  return stack;
}

} // namespace

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::unique_ptr<cuda::Executor> executorOf(const Options& o) {
#ifdef INNERGS_BENCHMARK_CUDA
  if (!o.host) return cuda::makeCudaExecutor(0);
#endif
  return cuda::makeHostExecutor();
}

Volume waves(std::int64_t nx, std::int64_t ny, std::int64_t nz) {
  Volume v;
  v.geometry.size = {nx, ny, nz};
  v.voxels.reserve(static_cast<std::size_t>(nx * ny * nz));
  std::vector<double> along;
  for (std::int64_t i = 0; i < nx; ++i)
    along.push_back(std::sin(0.21 * static_cast<double>(i)));
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const double row = 60 * std::cos(0.17 * static_cast<double>(j)),
                   base = 100 + 20 * std::sin(0.3 * static_cast<double>(k));
      for (const double x : along)
        v.voxels.push_back(static_cast<float>(base + row * x));
    }
  return v;
}

JobRun job(const Volume& volume, const Sizes& sizes, const std::string& device, int threads) {
  Settings settings;
  settings.gaussians = sizes.gaussians;
  settings.device = device;
  settings.threads = threads;
  if (sizes.jobIterations > 0) settings.iterations = sizes.jobIterations;
  ReconstructionInput input;
  input.stacks = {stackOf(volume)};
  const IntensityMap map = chooseIntensityMap(input.stacks);
  Settings planned = settings;
  const int coarse = makePlan(planned, measureTraits(input.stacks, map)).coarseIterations;
  const auto [low, high] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
  const double shift = 20 * std::log10((*high - *low) / map.scale); // as in the paper: of the whole range
  JobRun run;
  ReconstructionJob work(std::move(input), settings);
  work.onProgress([&](const Progress& p) {
    if (p.phase != Phase::Fitting || p.iteration == 0) return;
    if (std::isnan(run.firstIteration)) run.firstIteration = p.elapsed;
    if (p.iteration > coarse && std::isnan(run.toPaper) && p.trainingPsnr + shift >= kPaperPsnr)
      run.toPaper = p.elapsed;
  });
  const ReconstructionResult result = work.run();
  run.seconds = result.seconds;
  run.fitSeconds = result.fitSeconds;
  run.psnr = result.trainingPsnr + shift;
  run.iterations = result.iterations;
  run.device = result.device.id;
  for (const std::string& warning : result.warnings)
    std::printf("warning: %s\n", warning.c_str());
  return run;
}

Scene sceneOf(const Volume& volume, const Sizes& sizes, Blending blending) {
  Settings settings;
  settings.blending = blending;
  settings.gaussians = sizes.gaussians;
  settings.iterations = std::min(40, sizes.jobIterations > 0 ? sizes.jobIterations : 40);
  settings.ensembleSize = 1;
  settings.device = "cpu";
  ReconstructionInput input;
  const Stack stack = stackOf(volume);
  input.stacks = {stack};
  Scene scene;
  scene.field = ReconstructionJob(std::move(input), settings).run().model->field;
  for (int axis = 2; axis >= (blending == Blending::Alpha ? 0 : 2); --axis)
    for (Observation& o : observe(withSliceAxis(stack, axis), scene.field.modelToWorld,
                                  {scene.field.intensityScale, scene.field.intensityOffset}, false))
      scene.observations.push_back(std::move(o));
  return scene;
}

FitRequest requestOf(const Scene& scene) {
  FitRequest request;
  request.observations = std::make_shared<const std::vector<Observation>>(scene.observations);
  request.blending = scene.field.blending;
  request.linearIntensity = scene.field.linearIntensity;
  request.gaussians = scene.field.size();
  request.rules.bounds = {std::log(0.1), std::log(60)};
  return request;
}

double iterationSeconds(cuda::Fit& fit, const GaussianField& field, int repeats, int relocateEvery) {
  const std::size_t run = repeats > 1 ? 20 : 2;
  fit.upload(field, Adam(field.size()), {});
  std::vector<IterationOptions> iterations(run);
  int step = 0;
  const auto iteration = [&] {
    for (IterationOptions& options : iterations) {
      options.step = ++step;
      options.relocate.reset();
      if (relocateEvery > 0 && step % relocateEvery == 0) options.relocate = RelocationPlan{0.02, -3};
    }
    for (std::size_t done = 0; done < run;)
      done += fit.iterateMany(std::span(iterations).subspan(done)).size();
  };
  iteration(); // loads the kernels and allocates
  std::vector<double> seconds;
  for (int i = 0; i < repeats; ++i)
    seconds.push_back(timed(iteration) / static_cast<double>(run));
  return median(seconds);
}

double cpuIterationSeconds(const Scene& scene, int threads, int repeats) {
  ThreadPool pool(threads);
  FitPlan plan;
  plan.linearIntensity = scene.field.linearIntensity;
  plan.iterations = 1 << 30;
  plan.cutoff = scene.field.cutoff;
  Trainer trainer(scene.field, scene.observations, plan, kernelSet(""), pool);
  trainer.step();
  std::vector<double> seconds;
  for (int i = 0; i < repeats; ++i)
    seconds.push_back(timed([&] { trainer.step(); }));
  return median(seconds);
}

double largeIteration(const Options& o, const Sizes& sizes, std::int64_t& gaussians) {
  Scene scene;
  const std::int64_t n = sizes.large;
  const double spacing = static_cast<double>(n) / sizes.largeEdge;
  scene.field.cutoff = 2.2;
  for (int k = 0; k < sizes.largeEdge; ++k)
    for (int j = 0; j < sizes.largeEdge; ++j)
      for (int i = 0; i < sizes.largeEdge; ++i) {
        Gaussian g{};
        const int at[3] = {i, j, k};
        for (int a = 0; a < 3; ++a) {
          g.mean[a] = static_cast<float>((at[a] + 0.5) * spacing - 0.5);
          g.logScale[a] = static_cast<float>(std::log(0.5 * spacing));
        }
        g.quaternion[0] = 1;
        g.intensity = 0.5f;
        g.logWeight = -0.1f;
        scene.field.gaussians.push_back(g);
      }
  gaussians = scene.field.size();
  {
    const Stack stack = stackOf(waves(n, n, n));
    scene.observations = observe(stack, {}, {200, 0}, false);
  }
  FitRequest request;
  request.observations = std::make_shared<const std::vector<Observation>>(std::move(scene.observations));
  request.gaussians = scene.field.size();
  request.rules.bounds = {std::log(0.1), std::log(60)};
  cuda::Fit fit(executorOf(o), request);
  if (!fit.remark().empty()) std::printf("%s\n", fit.remark().c_str());
  return iterationSeconds(fit, scene.field, std::min(o.repeats, 3));
}

double planeMilliseconds(const Options& o, const Sizes& sizes, const Scene& scene, const Volume& volume) {
  cuda::Field field(executorOf(o), scene.field);
  const GridGeometry& g = volume.geometry;
  SampleGrid grid;
  grid.nx = grid.ny = sizes.plane;
  grid.z = {0};
  // Through the middle of the volume, rotated about two axes; the steps make it span the volume.
  const double step = g.spacing[0] * static_cast<double>(g.size[0]) / sizes.plane;
  grid.indexToModel.linear = {
      {{{0.8 * step, -0.36 * step, 0.48}, {0.6 * step, 0.48 * step, -0.64}, {0, 0.8 * step, 0.6}}}};
  const Affine3 toModel = inverse(scene.field.modelToWorld) * g.indexToWorld();
  Vec3 middle;
  for (int a = 0; a < 3; ++a)
    middle[a] = 0.5 * static_cast<double>(g.size[a] - 1);
  middle = toModel(middle);
  const Vec3 half = grid.indexToModel({0.5 * sizes.plane, 0.5 * sizes.plane, 0});
  for (int a = 0; a < 3; ++a)
    grid.indexToModel.offset[a] = middle[a] - half[a];
  std::vector<float> out(static_cast<std::size_t>(sizes.plane) * sizes.plane);
  std::vector<double> seconds;
  for (int i = 0; i < 5 + 7 * o.repeats; ++i) {
    const double s = timed([&] { field.renderGrid(grid, {}, {}, out.data(), {}); });
    if (i >= 5) seconds.push_back(s);
  }
  const double largest = *std::max_element(out.begin(), out.end());
  if (!(largest > 0.05)) std::printf("warning: the plane is empty\n");
  return 1e3 * median(seconds);
}

} // namespace innergs::bench
