#pragma once
#include "Core/Motion/DynamicField.h"
#include "Core/Render/Render.h"

#include <string>

namespace innergs {

/// Frames of a continuous volume in space and time on one grid.
class FrameRenderer {
public:
  /// device: as in Settings; "auto" takes one where a frame is large, as renderingDevice() does. The field
  /// must outlive this.
  FrameRenderer(const DynamicField& field, const GridGeometry& grid, RenderOptions options,
                std::string device = "auto");

  /// The frame at a time (s), voxels as in Volume. Throws as DeviceChoice does, Error(Cancelled).
  std::vector<float> at(double time);
  /// Why the device that was asked for did not render, a sentence; "": it did, or the CPU was as good.
  const std::string& problem() const { return problem_; }

private:
  const DynamicField& field_;
  GridGeometry grid_;
  RenderOptions options_;
  std::string device_, problem_;
  ThreadPool pool_;
  GaussianField posed_;
};

} // namespace innergs
