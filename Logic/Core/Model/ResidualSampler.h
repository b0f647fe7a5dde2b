#pragma once
#include "Core/Model/GaussianField.h"

namespace innergs {

/// A field's residual grid at continuous indices of another grid; 0 outside it. Between the voxels it is
/// interpolated by cubic convolution (Keys, IEEE Trans. ASSP 29, 1981, eq. 4 with a = −3/4).
class ResidualSampler {
public:
  ResidualSampler(const GaussianField& field, const Affine3& indexToWorld) : residual_(field.residual) {
    if (!residual_.voxels.empty()) map_ = inverse(residual_.geometry.indexToWorld()) * indexToWorld;
  }

  float operator()(const Vec3& index) const { return residual_.voxels.empty() ? 0 : sample(map_(index)); }

private:
  float sample(const Vec3& index) const; // of the grid

  const Volume& residual_;
  Affine3 map_;
};

} // namespace innergs
