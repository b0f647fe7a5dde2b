#include "Microbenchmarks.h"
#include "Scene.h"

#include "Core/Job/ReconstructionJob.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"

#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>

namespace innergs::bench {
namespace {

/// A drag: 512×512 pixels across the volume in an oblique direction, each call a little further along its
/// normal.
void planeQuery(benchmark::State& state) {
  static int calls = 0;
  static vtkNew<vtkInnerGSPlaneQuery> query;
  const GridGeometry& grid = scene().stack.image.geometry;
  const Vec3 extent = grid.extent(), centre = grid.centre();
  if (calls == 0) {
    auto core = std::make_shared<Model>();
    core->field = scene().field;
    vtkNew<vtkInnerGSModel> model;
    model->SetCoreModel(core);
    query->SetModel(model);
    query->SetDimensions(512, 512);
    const double pixel = 1.2 * std::max({extent[0], extent[1], extent[2]}) / 512;
    query->SetSpacing(pixel, pixel);
    query->Update(); // what is kept between queries
  }
  const double step = 0.1 * extent[2] * std::sin(0.05 * ++calls);
  const double axes[3][3] = {{2. / 3, -1. / 3, 2. / 3}, {2. / 3, 2. / 3, -1. / 3}, {-1. / 3, 2. / 3, 2. / 3}};
  const double ras[3] = {-centre[0], -centre[1], centre[2]};
  vtkNew<vtkMatrix4x4> plane;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      plane->SetElement(r, c, axes[r][c]);
    plane->SetElement(r, 3, ras[r] + step * axes[r][2]);
  }
  for (auto _ : state) {
    query->SetPlaneToRASMatrix(plane);
    query->Update();
  }
  if (query->GetErrorCode() != 0) state.SkipWithError(query->GetErrorMessage().c_str());
}

} // namespace

void registerVTKBenchmarks() {
  benchmark::RegisterBenchmark("plane_query", planeQuery)
      ->Iterations(1)
      ->Repetitions(200)
      ->ReportAggregatesOnly(true)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

} // namespace innergs::bench
