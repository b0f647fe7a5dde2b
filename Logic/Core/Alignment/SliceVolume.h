#pragma once
#include "Core/Alignment/SliceOperator.h"

namespace innergs {

struct SliceVolumePlan {
  double smoothness = 0.05; // weight of squared differences of neighbours, relative to the mean data weight
  int iterations = 8;       // conjugate gradients (Hestenes and Stiefel 1952), from the volume as it stands
};

/// Finds the volume that explains slices best: minimises Σ weight·(gain·(slice operator)·volume − slice)² +
/// smoothness·Σ (differences of neighbours)². Bit-identical for any number of threads. Throws
/// Error(Cancelled).
void fitVolume(std::vector<float>& volume, const SliceOperator& op,
               std::span<const PlacedSlice* const> slices, const SliceVolumePlan& plan, ThreadPool& pool);

} // namespace innergs
