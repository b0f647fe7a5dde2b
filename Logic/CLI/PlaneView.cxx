#include "CLI/PlaneView.h"

#include <algorithm>
#include <cmath>

namespace innergs::cli {

PlaneView::PlaneView(const GridGeometry& g, Plane p, std::int64_t slice, double mmPerPixel)
    : plane(p), across_(sliceAxis(g, plane == Plane::Sagittal ? Plane::Coronal : Plane::Sagittal)),
      down_(sliceAxis(g, plane == Plane::Axial ? Plane::Coronal : Plane::Axial)),
      through_(sliceAxis(g, plane)), flipAcross_(g.direction[plane == Plane::Sagittal ? 1 : 0][across_] < 0),
      flipDown_(plane == Plane::Axial ? g.direction[1][down_] < 0 : g.direction[2][down_] > 0), slice_(slice),
      spacing_(g.spacing), step_(mmPerPixel) {
  width = std::max(1, static_cast<int>(std::lround(g.extent()[across_] / step_)));
  height = std::max(1, static_cast<int>(std::lround(g.extent()[down_] / step_)));
}

void PlaneView::draw(Picture& picture, int left, int top, const ColourAt& colour) const {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Vec3 index;
      index[across_] = indexAt(flipAcross_ ? width - 1 - x : x, across_);
      index[down_] = indexAt(flipDown_ ? height - 1 - y : y, down_);
      index[through_] = static_cast<double>(slice_);
      picture.set(left + x, top + y, colour(index));
    }
}

} // namespace innergs::cli
