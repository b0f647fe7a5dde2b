// A field of one wide Gaussian, rendered; with IO written and read again. Usage: Consumer IMAGE
#include "Core/Render/Render.h"
#include "IO/ModelFile.h"

#include <cmath>
#include <cstdio>
#include <numeric>
#ifdef WITH_IO
#include "IO/VolumeIO.h"
#endif

int main(int, char** arguments) {
  const float width = std::log(100.0F); // mm
  innergs::Model model;
  model.field.gaussians = {{{1.5F, 1.5F, 1.5F}, {width, width, width}, {1, 0, 0, 0}, 0, 7.5F, {0, 0, 0}, 0}};
  innergs::GridGeometry grid;
  grid.size = {4, 4, 4};
  innergs::Volume volume = innergs::render(model.field, grid);
#ifdef WITH_IO
  innergs::writeVolume(volume, arguments[1]);
  volume = innergs::readVolume(arguments[1]);
#endif
  model.field.domain = grid;
  const std::string file = std::string(arguments[1]) + ".innergs";
  innergs::writeModel(model, file);
  if (innergs::readModel(file).field.size() != 1) return 1;
  const double sum = std::accumulate(volume.voxels.begin(), volume.voxels.end(), 0.0);
  std::printf("mean %.1f of %zu voxels\n", sum / double(volume.voxels.size()), volume.voxels.size());
}
