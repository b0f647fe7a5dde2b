#pragma once
#include "Core/Image/Linear.h"
#include "Evaluation/ExperimentTable.h"

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

namespace innergs {

/// Checks the paper's appendix: the conditional splat p(u,v|t)·p(t) has the same iso-contours as the 3D
/// Gaussian cut by the slice.
struct ContourCheck {
  int gaussians = 500; // random, each cut by slices of a random orientation
  int slices = 7;      // per Gaussian, t from −2.7 to 2.7 standard deviations
  int grid = 41;       // points along u and v per slice, over ±3.3 standard deviations
  int directions = 72; // rays along which contours are compared
  std::uint64_t seed = 1;
};

/// One slice of one Gaussian, for the picture. Positions in slice coordinates (u, v), mm.
struct ContourSlice {
  double t = 0;      // distance to the Gaussian's centre, standard deviations along the normal
  double extent = 0; // half the width of the square that `sliced` covers, mm; the centre is (0, 0)
  int size = 0;
  std::vector<float> sliced; // the 3D Gaussian on the slice, size×size, u fastest
  struct Contour {
    double level;
    std::vector<std::array<double, 2>> sliced, splat; // closed; empty if the level is not reached
  };
  std::vector<Contour> contours;
};

struct ContourResult {
  std::int64_t points = 0, contourPoints = 0;
  double maximumError = 0;    // |splat − slice| of p (peak 1), over all points
  double maximumDistance = 0; // between the two contours along a ray, in units of the slice's larger σ
  std::vector<ContourSlice> example; // one oblique Gaussian through several slices
};

/// Double precision throughout: the 3D Gaussian from its rotation and scales in its own axes, the splat from
/// its covariance in slice coordinates. Contours of the slice are found by bisection, those of the splat in
/// closed form. Throws Error(InvalidArgument) if there is nothing to compare, Error(Cancelled).
ContourResult checkContours(const ContourCheck& check = {}, std::stop_token stop = {});

ExperimentTable contourTable(const ContourCheck& check, const ContourResult& result);

} // namespace innergs
