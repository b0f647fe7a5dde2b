#include "Core/Motion/FrameRenderer.h"

#include "Core/Device/Devices.h"

namespace innergs {

FrameRenderer::FrameRenderer(const DynamicField& field, const GridGeometry& grid, RenderOptions options,
                             std::string device)
    : field_(field), grid_(grid), options_(std::move(options)), device_(std::move(device)),
      pool_(options_.threads), posed_(field.canonical) {
  pool_.setStop(options_.stop);
}

std::vector<float> FrameRenderer::at(double time) {
  poseAt(field_, time, posed_, pool_);
  if (problem_.empty())
    options_.device = renderingDevice(device_, posed_, grid_.voxelCount(), options_.instructionSet,
                                      options_.selection, &problem_);
  std::vector<float> frame = render(posed_, grid_, options_).voxels;
  options_.device.reset(); // it holds only the field at this time
  return frame;
}

} // namespace innergs
