#pragma once
#include "Core/Model/GaussianField.h"

namespace innergs {

/// A field's residual grid at continuous indices of a lattice; 0 outside it.
class ResidualSampler {
public:
  ResidualSampler(const GaussianField& field, const Affine3& indexToWorld) : residual_(field.residual) {
    if (!residual_.voxels.empty()) map_ = inverse(residual_.geometry.indexToWorld()) * indexToWorld;
  }
  float operator()(const Vec3& index) const {
    float value = 0;
    if (!residual_.voxels.empty())
      sampleInside(residual_.geometry, residual_.voxels.data(), map_(index), value);
    return value;
  }

private:
  const Volume& residual_;
  Affine3 map_;
};

} // namespace innergs
