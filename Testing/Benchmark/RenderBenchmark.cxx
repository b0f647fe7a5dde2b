#include "Microbenchmarks.h"
#include "Scene.h"

#include "Core/Alignment/TrilinearRows.h"
#include "Core/Base/Random.h"
#include "Core/Image/CubicConvolution.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"

#include <algorithm>

namespace innergs::bench {
namespace {

/// 512×512 pixels through the middle of the volume, in an oblique direction.
GridGeometry obliquePlane() {
  const GridGeometry& grid = scene().stack.image.geometry;
  const Vec3 extent = grid.extent(), centre = grid.centre();
  const double pixel = 1.2 * std::max({extent[0], extent[1], extent[2]}) / 512;
  GridGeometry plane;
  plane.size = {512, 512, 1};
  plane.spacing = {pixel, pixel, pixel};
  plane.direction[0] = {2. / 3, -1. / 3, 2. / 3};
  plane.direction[1] = {2. / 3, 2. / 3, -1. / 3};
  plane.direction[2] = {-1. / 3, 2. / 3, 2. / 3};
  const Vec3 half = plane.direction * Vec3{255.5 * pixel, 255.5 * pixel, 0};
  plane.origin = centre - half;
  return plane;
}

void obliqueSlice(benchmark::State& state) {
  const GridGeometry plane = obliquePlane();
  for (auto _ : state)
    benchmark::DoNotOptimize(render(scene().field, plane));
}

void wholeVolume(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(render(scene().field, scene().stack.image.geometry));
}

void points(benchmark::State& state) {
  const GridGeometry& grid = scene().stack.image.geometry;
  const Affine3 map = grid.indexToWorld();
  Random random(1);
  std::vector<Vec3> points(static_cast<std::size_t>(state.range(0)));
  for (Vec3& p : points)
    p = map({random.uniform() * (grid.size[0] - 1.), random.uniform() * (grid.size[1] - 1.),
             random.uniform() * (grid.size[2] - 1.)});
  for (auto _ : state)
    benchmark::DoNotOptimize(renderPoints(scene().field, points));
}

/// Oblique rows of half a voxel's step through the residual grid; one thread.
void cubicRows(benchmark::State& state, const CubicConvolution& kernels) {
  constexpr int kRow = 512, kRows = 64;
  const Volume& residual = scene().field.residual;
  const Vec3 step{1. / 3, 1. / 3, -1. / 6};
  Vec3 start = inverse(residual.geometry.indexToWorld())(residual.geometry.centre()) - 0.5 * kRow * step;
  std::vector<float> row(kRow);
  for (auto _ : state)
    for (int r = 0; r < kRows; ++r) {
      kernels.add(residual, start + Vec3{-0.17 * r, 0.34 * r, 0.34 * r}, step, kKeys, 0, kRow, row.data());
      benchmark::DoNotOptimize(row.data());
    }
  state.counters["points_per_second"] =
      benchmark::Counter(kRow * kRows, benchmark::Counter::kIsIterationInvariantRate);
}

/// Rows as of a tilted slice that is registered, through the residual grid; one thread.
void trilinearRowsOf(benchmark::State& state, const TrilinearRows& kernels, bool transposed) {
  constexpr int kRow = 64, kRows = 64;
  const Volume& residual = scene().field.residual;
  std::vector<float> volume = residual.voxels, values(kRow, 1.f);
  PointRow row{residual.geometry.size, {}, {0.8F, 0.04F, -0.02F}};
  for (auto _ : state)
    for (int r = 0; r < kRows; ++r) {
      const float middle[] = {-26, 0.8F * static_cast<float>(r - kRows / 2), 0.01F * static_cast<float>(r)};
      for (int a = 0; a < 3; ++a)
        row.start[a] = 0.5F * static_cast<float>(row.size[a]) + middle[a];
      if (transposed)
        kernels.add(values.data(), row, 1e-6F, 0, kRow, 0, row.size[2], volume.data());
      else
        kernels.read(volume.data(), row, 1e-6F, 0, kRow, values.data());
      benchmark::ClobberMemory();
    }
  state.counters["points_per_second"] =
      benchmark::Counter(kRow * kRows, benchmark::Counter::kIsIterationInvariantRate);
}

} // namespace

void registerRenderBenchmarks() {
  // Single calls, as in a user's drag, and their median.
  const auto calls = [](benchmark::internal::Benchmark* b, int times) {
    b->Iterations(1)
        ->Repetitions(times)
        ->ReportAggregatesOnly(true)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  };
  calls(benchmark::RegisterBenchmark("oblique_slice", obliqueSlice), 51);
  calls(benchmark::RegisterBenchmark("whole_volume", wholeVolume), 9);
  calls(benchmark::RegisterBenchmark("points", points)->ArgName("points")->Arg(1)->Arg(100000), 9);
  for (const CubicConvolution& set : cubicConvolutions())
    steady(benchmark::RegisterBenchmark(("cubic_convolution/" + set.name).c_str(), cubicRows, set));
  for (const TrilinearRows& set : trilinearRows()) {
    steady(benchmark::RegisterBenchmark(("trilinear_rows/" + set.name).c_str(), trilinearRowsOf, set, false));
    steady(benchmark::RegisterBenchmark(("trilinear_rows_transposed/" + set.name).c_str(), trilinearRowsOf,
                                        set, true));
  }
}

} // namespace innergs::bench
