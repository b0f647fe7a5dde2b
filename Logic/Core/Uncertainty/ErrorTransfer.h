#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"
#include "Core/Uncertainty/ErrorCurve.h"

#include <array>
#include <functional>

namespace innergs {

/// A voxel of a held-out slice, and what a fit without that slice predicted.
struct HeldOutValue {
  Vec3 at;              // LPS mm, where the fit put it
  float difference = 0; // predicted minus measured, scanner units
  int slice = 0;        // counts the held-out slices of all stacks
};

/// The volumes of two fits on one grid: to all slices, and without some of them.
struct FitPair {
  Volume whole, second;
  std::vector<HeldOutValue> seen;
};
/// Runs both fits on `stacks`, as for the real scans. An empty second volume: nothing could be held out.
using PairFitter = std::function<FitPair(std::vector<Stack> stacks, const GridGeometry& grid)>;

/// Turns errors at held-out slices into errors of the volume that was fitted to all slices: their squares,
/// without the noise, times a slope, plus an offset (what noise does to the volume), by distance to the
/// slices. Found by simulation, where the truth is known: the volume, turned out of its axes, is scanned as
/// the stacks scanned the patient (grids, profiles, noise), in a cube around its detail, and fitted as
/// they were. Simulated slices agree with each other; of the squares of what real ones are missed by beyond
/// that, half is taken for detail finer than the volume's, which the slope applies to, and half for motion
/// and changes of intensity, which do not shrink where slices are nearer.
class ErrorTransfer {
public:
  /// stacks: as they lie in the volume. moved: their slices were moved, and the simulated ones lie where they
  /// do; other poses are ignored. noise: standard deviation. radius: mm, of localDetail(). Throws
  /// Error(NoData) where the cube shows too little, Error(Cancelled).
  ErrorTransfer(const Volume& volume, std::span<const Stack> stacks, bool moved, double noise, double radius,
                const PairFitter& fit, ThreadPool& pool);

  /// The volume's standard deviation where ErrorCurve gives `seen` for held-out slices at this local detail.
  double deviation(double seen, double detail, double distance) const;

  struct Line {
    double slope = 1, offset = 0, least = 0; // of squares; least: below which no error is
  };

private:
  static constexpr int kNear = 3;
  static int distanceClass(double distance);
  double noise_;
  ErrorCurve simulated_; // at held-out slices
  std::array<Line, kNear> line_;
};

} // namespace innergs
