#pragma once
#include "Core/GaussianField.h"
#include "Core/Lattice.h"
#include "Core/Parallel.h"
#include "Core/Selection.h"

namespace innergs {

/// One Gaussian in a lattice's index coordinates, ready for the kernels. The mean is cell + fraction, so that
/// distances to voxels keep full float precision. Exponents are in base 2: w·p = exp2(quadratic(d) +
/// log2Weight).
struct Projected {
  std::int32_t cell[3];
  float fraction[3];
  float quadratic[6];                    // −½·log2(e)·P with the mixed terms doubled: xx xy xz yy yz zz
  float log2Weight;                      // alpha blending: log2 α
  float log2Cut;                         // exponent at the cut-off radius, weight included
  float cut;                             // w·p there: subtracted, so that p is continuous
  float value;                           // c
  float slope[3];                        // g per index step
  float radius2;                         // squared cut-off (Mahalanobis)
  float precisionY, shiftYZ, precisionZ; // row form: b, l3, 1/Σzz
  float half[3]; // half extents of what the selection reaches (Exact: the cut-off ellipsoid), index units
  float shiftXZ, square; // Method2: conditional mean of x per step of z; half edge of its square at dz = 0
};

/// The observation kernel of a slice in closed form (additive blending): a covariance added to every
/// Gaussian's, model frame, mm²; xx xy xz yy yz zz.
struct ClosedFormPsf {
  bool active = false;
  float covariance[6] = {};
};

/// `values`: replaces intensity and slope when not empty.
void project(const GaussianField& field, std::span<const float> values, const Lattice& lattice,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out,
             Selection selection = Selection::Exact);

} // namespace innergs
