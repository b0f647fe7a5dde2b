#include "Core/Projected.h"

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

} // namespace innergs
