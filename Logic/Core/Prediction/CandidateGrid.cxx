#include "Core/Prediction/CandidateGrid.h"

#include <algorithm>
#include <cmath>

namespace innergs {

GridGeometry candidateGrid(const GridGeometry& stack, const GridGeometry& wanted) {
  const double fine = stack.finestSpacing();
  GridGeometry grid = withSpacing(stack, {stack.spacing[0], stack.spacing[1], fine});
  const Vec3 normal = column(stack.direction, 2);
  for (int a = 0; a < 3; ++a) {
    const double along = dot(column(wanted.direction, a), normal);
    const double spacing = wanted.spacing[a] / std::max(1.0, std::round(wanted.spacing[a] / fine));
    if (std::abs(std::abs(along) - 1) > 1e-6 || spacing < 0.6 * fine) continue;
    const double extent = stack.extent()[2];
    const Vec3 start = stack.indexToWorld()({0, 0, -0.5}); // the box's first face
    double offset = std::fmod(dot(wanted.origin - start, normal), spacing);
    if (offset < 0) offset += spacing;
    if (offset > 0.5 * spacing + 1e-6 * spacing) offset -= spacing; // the first plane's cell holds that face
    grid = stack;
    grid.spacing[2] = spacing;
    grid.size[2] = static_cast<std::int64_t>(std::ceil((extent - offset) / spacing - 0.5 - 1e-6)) + 1;
    grid.origin = stack.indexToWorld()({0, 0, -0.5 + offset / stack.spacing[2]});
    break;
  }
  return grid;
}

} // namespace innergs
