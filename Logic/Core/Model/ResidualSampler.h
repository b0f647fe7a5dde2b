#pragma once
#include "Core/Image/CubicConvolution.h"
#include "Core/Model/GaussianField.h"

namespace innergs {

/// A field's residual grid at continuous indices of another grid; 0 outside it.
class ResidualSampler {
public:
  /// Of its cubic convolution.
  static constexpr float kKeys = -0.75F;

  /// instructionSet: empty for the best. Throws Error(InvalidArgument) for one that this processor lacks.
  ResidualSampler(const GaussianField& field, const Affine3& indexToWorld,
                  const std::string& instructionSet = {});

  float operator()(const Vec3& index) const {
    return residual_.voxels.empty() ? 0 : cubicAt(residual_, map_(index), kKeys);
  }

  /// row[x] += (*this)({x, y, z}) for x in [begin, end).
  void add(double y, double z, int begin, int end, float* row) const;

private:
  const Volume& residual_;
  const CubicConvolution& kernels_;
  Affine3 map_;
};

} // namespace innergs
