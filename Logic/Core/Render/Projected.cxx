#include "Core/Render/Projected.h"

#include "Core/Render/Rows.h"

#include <algorithm>

namespace innergs {

ProjectionFrame projectionFrame(const Lattice& lattice) {
  ProjectionFrame f;
  const Affine3 inv = inverse(lattice.indexToModel);
  for (int i = 0; i < 3; ++i) {
    f.offset[i] = inv.offset[i];
    for (int j = 0; j < 3; ++j) {
      f.inverse[3 * i + j] = inv.linear[i][j];
      f.toIndex[3 * i + j] = static_cast<float>(inv.linear[i][j]);
      f.toModelT[3 * i + j] = static_cast<float>(lattice.indexToModel.linear[j][i]);
    }
  }
  return f;
}

void project(const GaussianField& field, std::span<const float> values, const Lattice& lattice,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out, Selection selection) {
  const ProjectionFrame frame = projectionFrame(lattice);
  const ProjectionRules rules{static_cast<float>(field.cutoff * field.cutoff), field.blending,
                              field.linearIntensity, selection, psf};
  out.resize(field.gaussians.size());
  pool.blocks(field.size(), 2048, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i)
      projectGaussian(field.gaussians[i], values.empty() ? nullptr : &values[i], frame, rules, out[i]);
  });
}

float edgeClearance(const Projected& p, const Lattice& lattice) {
  const float* q = p.quadratic;
  float least = HUGE_VALF;
  for (double z : lattice.z) {
    const float dz = planeOffset(p, z);
    if (std::fabs(dz) > p.half[2] + 1) continue;
    for (int y = 0; y < lattice.ny; ++y) {
      const float dy = static_cast<float>(y - p.cell[1]) - p.fraction[1];
      if (std::fabs(dy) > p.half[1] + 1) continue;
      const float e0 = q[3] * dy * dy + q[4] * dy * dz + q[5] * dz * dz + p.log2Weight - p.log2Cut;
      for (int x = 0; x < lattice.nx; ++x) {
        const float dx = static_cast<float>(x - p.cell[0]) - p.fraction[0];
        least = std::min(least, std::fabs(e0 + dx * (q[0] * dx + q[1] * dy + q[2] * dz)));
      }
    }
  }
  return least;
}

} // namespace innergs
