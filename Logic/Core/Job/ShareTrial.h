#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Job/SimulatedFit.h"

#include <functional>

namespace innergs {

/// Part of a fitted volume, scanned and fitted anew as the scans were. There the truth is known, so that it
/// shows how large a share predictions from each scan alone should have.
struct ShareTrial {
  GridGeometry grid;
  Volume truth;      // on it; without voxels in an outline
  SimulatedFit twin; // no stacks: the part shows too little of one of the scans
};

/// render: the fitted volume on a lattice. domain: its lattice. settings: of its fit, as the user gave them.
/// noise: standard deviation. Throws Error(Cancelled).
ShareTrial shareTrial(const std::function<Volume(const GridGeometry&)>& render, std::span<const Stack> stacks,
                      const GridGeometry& domain, const Settings& settings, double noise, ThreadPool& pool);

/// For estimates: without voxels, in the middle of the stacks.
ShareTrial shareTrialOutline(std::span<const Stack> stacks, const Settings& settings);

/// The multiple of (mixed − unmixed) that brings the unmixed volume nearest to the truth, all on one lattice;
/// a few voxels beside its faces do not count.
double bestMultiple(const Volume& truth, const Volume& unmixed, const Volume& mixed);

} // namespace innergs
