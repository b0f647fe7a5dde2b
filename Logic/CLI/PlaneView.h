#pragma once
#include "CLI/Picture.h"
#include "Evaluation/Protocols.h"

#include <functional>

namespace innergs::cli {

using ColourAt = std::function<Colour(const Vec3&)>; // at an index on a grid

/// One slice of a grid in radiological orientation: the patient's left on the right, front or head up.
class PlaneView {
public:
  PlaneView(const GridGeometry& grid, Plane plane, std::int64_t slice, double mmPerPixel);

  void draw(Picture& picture, int left, int top, const ColourAt& colour) const;

  Plane plane;
  int width, height; // pixels

private:
  double indexAt(int pixel, int axis) const { return (pixel + 0.5) * step_ / spacing_[axis] - 0.5; }

  int across_, down_, through_; // grid axes
  bool flipAcross_, flipDown_;
  std::int64_t slice_;
  Vec3 spacing_;
  double step_; // mm per pixel
};

} // namespace innergs::cli
