#pragma once
#include "Core/Alignment/SliceOperator.h"

namespace innergs {

struct SliceVolumePlan {
  double smoothness = 0.05; // weight of squared differences of neighbours, beside that of the data at a voxel
  int iterations = 8;       // conjugate gradients, from the volume as it stands
};

/// The volume that explains slices best: minimises Σ weight·(gain·(slice operator)·volume − slice)² +
/// smoothness·Σ (differences of neighbours)². The bits do not depend on the number of threads. Throws
/// Error(Cancelled).
void fitVolume(std::vector<float>& volume, const SliceOperator& op,
               std::span<const PlacedSlice* const> slices, const SliceVolumePlan& plan, ThreadPool& pool);

} // namespace innergs
