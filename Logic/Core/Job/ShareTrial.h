#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Job/SimulatedFit.h"

#include <functional>

namespace innergs {

/// Part of a fitted volume, scanned and fitted again as the scans were. There the truth is known, so that it
/// shows how large a share predictions from each scan alone should have.
struct ShareTrial {
  Volume truth;       // without voxels in an outline
  SimulatedFit refit; // to its scans, on its grid; no stacks: it shows too little of one of them
};

/// render: the fitted volume on a grid. domain: its grid. settings: of its fit, as the user gave them.
/// noise: standard deviation. Throws Error(Cancelled).
ShareTrial shareTrial(const std::function<Volume(const GridGeometry&)>& render, std::span<const Stack> stacks,
                      const GridGeometry& domain, const Settings& settings, double noise, ThreadPool& pool);

/// For estimates: without voxels, in the middle of the stacks.
ShareTrial shareTrialOutline(std::span<const Stack> stacks, const Settings& settings);

/// The share of the predictions in the trial's fit, to see what they do.
constexpr double kTriedShare = 0.3;

/// The share with which the trial's fit would come nearest to the truth, from that fit without the
/// predictions and with kTriedShare of them, all on one grid; a few voxels beside its faces do not count.
/// Predictions help more there than with the real scans, the more so the more noise (of the intensity range)
/// there is, so some of it is taken off. 0: they would hardly help.
double chosenShare(const Volume& truth, const Volume& unmixed, const Volume& mixed, double noise);

} // namespace innergs
