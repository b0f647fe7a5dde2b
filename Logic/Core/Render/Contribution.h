#pragma once
#include "Core/Render/Projection.h"

#include <cmath>

namespace innergs {

/// A Gaussian's contribution at a point: w·p, c + g·d, and the distance along z in index units.
struct Contribution {
  float p, value, depth;
};

/// x: index coordinates. Returns false beyond the cut-off.
INNERGS_HD inline bool contributionAt(const Projected& g, const double* x, Contribution& c) {
  float d[3];
  for (int a = 0; a < 3; ++a)
    d[a] = static_cast<float>(x[a] - g.cell[a] - static_cast<double>(g.fraction[a]));
  const float* q = g.quadratic;
  const float e = q[0] * d[0] * d[0] + q[1] * d[0] * d[1] + q[2] * d[0] * d[2] + q[3] * d[1] * d[1] +
                  q[4] * d[1] * d[2] + q[5] * d[2] * d[2] + g.log2Weight;
  if (!(e >= g.log2Cut)) return false; // rejects NaN too
  c.p = std::exp2(e) - g.cut;
  c.value = g.value + g.slope[0] * d[0] + g.slope[1] * d[1] + g.slope[2] * d[2];
  c.depth = std::fabs(d[2]);
  return true;
}

} // namespace innergs
