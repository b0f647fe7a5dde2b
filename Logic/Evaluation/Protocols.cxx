#include "Evaluation/Protocols.h"

#include <cmath>

namespace innergs {

const char* planeName(Plane plane) {
  return plane == Plane::Axial ? "axial" : plane == Plane::Coronal ? "coronal" : "sagittal";
}

int sliceAxis(const GridGeometry& geometry, Plane plane) {
  // Patient axis (x: right-left, y: front-back, z: foot-head) for each plane; the best of the six
  // assignments.
  constexpr int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  double best = -1;
  const int* axisOfPatientAxis = permutations[0];
  for (const auto& p : permutations) {
    double sum = 0;
    for (int r = 0; r < 3; ++r)
      sum += std::abs(geometry.direction[r][p[r]]);
    if (sum > best + 1e-9) {
      best = sum;
      axisOfPatientAxis = p;
    }
  }
  return axisOfPatientAxis[plane == Plane::Axial ? 2 : plane == Plane::Coronal ? 1 : 0];
}

Plane planeAcross(const GridGeometry& geometry, int axis) {
  for (const Plane plane : {Plane::Axial, Plane::Coronal})
    if (sliceAxis(geometry, plane) == axis) return plane;
  return Plane::Sagittal;
}

} // namespace innergs
