#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <functional>
#include <limits>
#include <string>

namespace innergs {

/// The position of one slice relative to the others.
struct SlicePose {
  Affine3 pose;            // rigid, LPS mm: applied to where the stack's header puts the slice
  double displacement = 0; // mm, root mean square over the body in it; without any, over the slice
  double angle = 0;        // degrees
  double gain = 1;         // its values are multiplied by it
  double weight = 1;       // 0: it fits nowhere, and is left out
  double residual = 0;     // RMS difference to what the other scans show there, scan's units; NaN: unknown
};

struct SliceMotionPlan {
  bool always = false; // poses are kept even where they do not make the scans agree better
  int packets = 0;     // per stack: slices k, k + packets, … share one pose (interleaved); 0: none do
};

/// How well the others predict one stack's slices at their poses.
struct SliceAgreement {
  double correlation = std::numeric_limits<double>::quiet_NaN(); // in the body
  double psnr = correlation;                                     // dB, peak: the range of all; NaN: unknown
};

struct SliceMotion {
  bool moved = false;                         // false: every pose is the identity
  int packets = 0;                            // as in the plan; 0 where every packet is one slice
  std::vector<std::vector<SlicePose>> slices; // per stack
  std::vector<SliceAgreement> scans;          // per stack
  /// How well the scans predict each other's slices: PSNR in dB, peak: their range; NaN: unknown.
  double psnrBefore = 0, psnrAfter = 0;
  double displacement = 0, angle = 0; // medians over the slices, mm and degrees
  std::int64_t rejected = 0;          // slices of weight 0
};

/// Whether slices are clearly farther apart than their pixels.
bool hasThickSlices(const Stack& stack);

/// Finds one rigid transform per slice or packet of slices, and one gain per slice. Each stack's slices are
/// registered to the volume that all other stacks show, fitted to their current positions through their slice
/// profiles (fitVolume), stack after stack, coarse to fine: Gauss-Newton with analytic gradients of what the
/// slice sees of the volume, robust by Cauchy's weights, with priors of no motion (σ: 6 mm, 6°) and no gain
/// (σ of its logarithm: 0.5); slices that fit nowhere get weight 0. The mean motion is zero and so is the
/// mean logarithm of gains, weighed by squared values, so the result keeps the frame and scale of the input.
/// Volumes reach as far as observed voxels do. Needs at least two stacks without poses. Bit-identical for any
/// number of threads. Throws Error(Cancelled).
SliceMotion findSliceMotion(std::span<const Stack> stacks, const SliceMotionPlan& plan, ThreadPool& pool,
                            const std::function<void(double)>& progress = {});

/// What was found, as text for the user; "" if nothing was moved. Lists slices that were left out, that count
/// for less than half, or that moved or turned much farther than the
/// others. names: of the stacks.
std::string sliceMotionSentence(const SliceMotion& motion, std::span<const std::string> names);

/// Finds poses and gains of single slices (K) of a stack in a volume that was fitted without them, coarse to
/// fine. render: the volume on a grid of cubes, NaN or any value where it shows nothing. scales: also
/// looks for gains.
std::vector<SlicePose> placeSlices(const std::function<Volume(const GridGeometry&)>& render,
                                   const Stack& stack, std::span<const std::int64_t> slices, bool scales,
                                   ThreadPool& pool);

/// Bytes that findSliceMotion() needs if all voxels are observed; an upper bound otherwise.
std::int64_t sliceMotionMemory(std::span<const Stack> stacks);

/// Gives the stacks their poses and gains; slices of weight 0 become unobserved.
void applySliceMotion(const SliceMotion& motion, std::span<Stack> stacks);

} // namespace innergs
