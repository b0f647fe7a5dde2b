#pragma once
#include "Core/Model/GaussianField.h"

namespace innergs {

/// A field's detail grid at continuous indices of some lattice; 0 where there is none.
class DetailSampler {
public:
  DetailSampler(const GaussianField& field, const Affine3& indexToWorld) : detail_(field.detail) {
    if (!detail_.voxels.empty()) map_ = inverse(detail_.geometry.indexToWorld()) * indexToWorld;
  }
  float operator()(const Vec3& index) const {
    float value = 0;
    if (!detail_.voxels.empty()) sampleInside(detail_.geometry, detail_.voxels.data(), map_(index), value);
    return value;
  }

private:
  const Volume& detail_;
  Affine3 map_;
};

} // namespace innergs
