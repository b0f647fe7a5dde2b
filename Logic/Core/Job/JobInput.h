#pragma once
#include "Core/Fit/Plan.h"
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// The checked input of a fit, with masks applied and, on request, slices held out.
struct PreparedInput {
  std::vector<Stack> stacks;                      // `observed` is set where anything is left out
  std::vector<std::vector<std::int64_t>> heldOut; // per stack: held-out slices
  std::vector<std::vector<std::uint8_t>> scored;  // of stacks with held-out slices: observed before
                                                  // holding out
  GridGeometry domain;                            // of the field
  Mask support;                                   // of a masked fit, see GaussianField
  ValueRange range;                               // range of the fitted values
  GridGeometry outputGrid;
  std::int64_t nonFinite = 0;
  std::string fingerprint; // hash of voxels, geometry and what is observed
  std::vector<std::string> warnings;
};

/// May move and scale stacks and their slices; returns sentences for the user.
using CorrectStacks = std::function<std::vector<std::string>(std::span<Stack>)>;
/// Throws Error for everything that is wrong with the input: no or broken stacks, stacks that neither overlap
/// nor adjoin (with room for a slice between them), a wrong number of masks, an empty mask, nothing finite to
/// fit, an output grid apart from the data. Error(Cancelled) when stopped on the way. heldOut: without the
/// slices that heldOutFraction holds out. correct: called before the field's domain is laid out.
PreparedInput prepareInput(const ReconstructionInput& input, const std::stop_token& stop = {},
                           bool heldOut = false, const CorrectStacks& correct = {});

/// Whether slices get motions of their own: several scans without poses; unless that is asked for, of slices
/// clearly thicker than their pixels, or 3 mm apart or more.
bool correctsSlices(const Settings& settings, std::span<const Stack> stacks);

/// Whether what each scan shows alone between its slices takes part in the fit of several: presets balanced
/// and best, no masks, normalised blending, thick slices without poses, clearly farther apart than their
/// pixels, that do not mostly lie beside each other.
bool predictsEach(const Settings& settings, const DataTraits& traits, std::span<const Stack> stacks,
                  bool masked);

/// How far the pixels of one of these scans average (mm), see Stack. As set; if nothing is, of several scans
/// those with pixels clearly larger than another's average over their size.
double pixelWidth(const Stack& scan, std::span<const Stack> scans, const Settings& settings);

double voxelsOf(std::span<const Stack> stacks);

/// For messages. index: among the input's stacks, from 0.
std::string nameOf(const Stack& stack, std::size_t index);

/// Share of the slices held out where the uncertainty is asked for without a fraction.
constexpr double kUsualFraction = 0.2;

/// The share of the slices that the second fit does not see; 0: there is no such fit.
double heldOutFraction(const ReconstructionInput& input);

/// Throws Error(InvalidArgument) unless the fraction is in [0, 0.5].
void checkHeldOutFraction(double fraction);

/// The approximate share of the stacks' volume (mm³) that a fit inside the masks processes: blocks of `reach`
/// mm that contain a voxel of the largest mask. 1 without a mask or without its voxels.
double maskedShare(const ReconstructionInput& input, double volume, double reach);

/// The stacks that Gaussians are initialised from: held-out slices are interpolated linearly between the
/// nearest fitted ones. `bridged` holds the copies that this needs.
std::span<const Stack> startStacks(const PreparedInput& prepared, std::vector<Stack>& bridged);

/// The first stack's grid, extended to cover those whose centres lie outside of its box (slabs, stations). If
/// its slices have poses: dataDomain().
GridGeometry acquisitionGrid(std::span<const Stack> stacks);

/// The default output grid: isotropic at the finest spacing of all stacks, over the box of
/// acquisitionGrid(). Slices with poses that overlap count with their pixels alone.
GridGeometry defaultOutputGrid(std::span<const Stack> stacks);

/// The grid of a fitted field: axes of the first stack, finest spacing of all, over the box of all stacks.
GridGeometry dataDomain(std::span<const Stack> stacks);

/// The grid of a prediction between the slices of one scan, or of several that mostly lie beside each other:
/// candidateGrid() of the scan with the finest pixels, over the box of all.
GridGeometry predictedGrid(std::span<const Stack> stacks, const GridGeometry& output);

/// The rigid frame of the fit: axes of the first stack (made right-handed), origin at its centre.
Affine3 modelFrame(const GridGeometry& geometry);

} // namespace innergs
