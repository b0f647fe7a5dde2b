#pragma once
#include "Core/GaussianField.h"
#include "Core/Lattice.h"
#include "Core/Parallel.h"
#include "Core/Projection.h"

namespace innergs {

ProjectionFrame projectionFrame(const Lattice& lattice);

/// `values`: replaces intensity and slope when not empty.
void project(const GaussianField& field, std::span<const float> values, const Lattice& lattice,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out,
             Selection selection = Selection::Exact);

} // namespace innergs
