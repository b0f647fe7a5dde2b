#include "Evaluation/HeldOutProtocol.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Image/BodyMask.h"
#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/Region.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/BackProjectionBaseline.h"
#include "Evaluation/Baselines.h"
#include "Evaluation/EvaluationRuns.h"
#include "Evaluation/IntervalScore.h"
#include "Evaluation/TotalVariation.h"

#include <algorithm>

namespace innergs {
namespace {

void checkCase(const HeldOutCase& c) {
  const bool chosen = c.factor == 0 && c.kind == HeldOutCase::Kind::KeepEvery;
  if (!chosen && (c.factor < 2 || c.factor > 64))
    throw Error(ErrorCode::InvalidArgument, c.kind == HeldOutCase::Kind::KeepEvery
                                                ? "Keeping every k-th slice needs a k from 2 to 64."
                                                : "The slice thickness must be 2 to 64 voxels.");
  if (c.kind == HeldOutCase::Kind::Orthogonal && c.stacks != 2 && c.stacks != 3)
    throw Error(ErrorCode::InvalidArgument, "The number of orthogonal stacks must be 2 or 3.");
  if (c.axis < -1 || c.axis > 2 || (c.axis >= 0 && c.kind == HeldOutCase::Kind::Orthogonal))
    throw Error(ErrorCode::InvalidArgument,
                "The slices' axis must be -1 (axial), 0, 1 or 2, and -1 for orthogonal stacks.");
  if (!std::isfinite(c.noise) || c.noise < 0)
    throw Error(ErrorCode::InvalidArgument, "The noise must be finite and at least zero.");
}

HeldOutCase resolved(HeldOutCase c, const GridGeometry& geometry) {
  if (c.axis == -1) c.axis = sliceAxis(geometry, Plane::Axial);
  if (c.kind == HeldOutCase::Kind::KeepEvery && c.factor == 0) c.factor = usualGap(geometry, c.axis);
  return c;
}

std::string caseName(const HeldOutCase& c) {
  std::string name = c.kind == HeldOutCase::Kind::KeepEvery ? formatted("keep-every-%d", c.factor)
                     : c.kind == HeldOutCase::Kind::Thick
                         ? formatted("thick-%d", c.factor)
                         : formatted("orthogonal-%d-thick-%d", c.stacks, c.factor);
  if (c.noise > 0) name += formatted("-noise-%g", c.noise);
  return name;
}

// Slice axes of the stacks: K after the permutation, then coronal and sagittal.
std::vector<int> stackAxes(const GridGeometry& geometry, const HeldOutCase& c) {
  std::vector<int> axes{2};
  if (c.kind == HeldOutCase::Kind::Orthogonal) {
    axes.push_back(sliceAxis(geometry, Plane::Coronal));
    if (c.stacks == 3) axes.push_back(sliceAxis(geometry, Plane::Sagittal));
  }
  return axes;
}

} // namespace

int usualGap(const GridGeometry& scan, int axis) {
  constexpr std::int64_t few = 16;
  const GridGeometry slices = withSliceAxis(scan, axis < 0 ? sliceAxis(scan, Plane::Axial) : axis);
  const bool apart = slices.spacing[2] > 1.4 * std::min(slices.spacing[0], slices.spacing[1]);
  return apart || slices.size[2] < few ? 2 : 4;
}

ReconstructionInput keptOutline(const GridGeometry& scan, int factor, int axis) {
  if (axis < 0) axis = sliceAxis(scan, Plane::Axial);
  if (factor == 0) factor = usualGap(scan, axis);
  ReconstructionInput kept;
  Stack& stack = kept.stacks.emplace_back();
  GridGeometry& grid = stack.image.geometry;
  kept.outputGrid = grid = withSliceAxis(scan, axis);
  grid.size[2] = std::max<std::int64_t>(2, (grid.size[2] - 1) / factor + 1);
  grid.spacing[2] *= factor;
  stack.thickness = kept.outputGrid->spacing[2];
  return kept;
}

EvaluationInput heldOutInput(const Volume& volume, const HeldOutCase& heldOutCase, std::uint64_t seed) {
  checkGeometry(volume.geometry, "The volume");
  checkCase(heldOutCase);
  const HeldOutCase c = resolved(heldOutCase, volume.geometry);
  EvaluationInput input;
  input.truth = withSliceAxis(volume, c.axis);
  const std::vector<int> axes = stackAxes(input.truth.geometry, c);
  std::array<std::int64_t, 3> size = input.truth.geometry.size;
  for (int axis : axes) {
    const std::int64_t n = size[axis];
    size[axis] =
        c.kind == HeldOutCase::Kind::KeepEvery ? (n - 1) / c.factor * c.factor + 1 : n / c.factor * c.factor;
    const std::int64_t slices =
        c.kind == HeldOutCase::Kind::KeepEvery ? (n - 1) / c.factor + 1 : n / c.factor;
    if (slices < 2)
      throw Error(ErrorCode::InvalidArgument, "The volume has " + std::to_string(n) +
                                                  (n == 1 ? " slice" : " slices") +
                                                  ", too few for this case: lower its factor.");
  }
  if (size != input.truth.geometry.size) input.truth = cropped(input.truth, IndexBlock{{0, 0, 0}, size});
  if (c.kind == HeldOutCase::Kind::KeepEvery) {
    Volume noisy = input.truth;
    if (c.noise > 0) noisy.voxels = simulateThickStack(noisy, 2, 1, c.noise, seed).image.voxels;
    input.stacks.push_back(keepEvery(noisy, 2, c.factor));
    for (std::int64_t k = 0; k < size[2]; ++k)
      if (k % c.factor != 0) input.testSlices.push_back(k);
  } else {
    for (std::size_t s = 0; s < axes.size(); ++s)
      input.stacks.push_back(simulateThickStack(input.truth, axes[s], c.factor, c.noise, seed + s));
    for (std::int64_t k = 0; k < size[2]; ++k)
      input.testSlices.push_back(k);
  }
  for (std::size_t s = 0; s < input.stacks.size(); ++s)
    input.stacks[s].name = planeName(planeAcross(input.truth.geometry, axes[s]));
  return input;
}

EvaluationReport evaluateHeldOut(const Volume& volume, const HeldOutCase& heldOutCase,
                                 const EvaluationOptions& options) {
  checkGeometry(volume.geometry, "The volume");
  checkCase(heldOutCase);
  const HeldOutCase c = resolved(heldOutCase, volume.geometry);
  EvaluationInput input = heldOutInput(volume, heldOutCase, options.settings.seed);
  const GridGeometry grid = input.truth.geometry;
  const bool several = input.stacks.size() > 1;
  const int threads = options.settings.threads;
  const std::vector<std::uint8_t> mask =
      options.mask ? resampleMask(*options.mask, grid) : bodyMask(input.truth, options.stop);
  if (options.mask && std::find(mask.begin(), mask.end(), 1) == mask.end())
    throw Error(ErrorCode::NoData, "The mask does not overlap the volume: check that it belongs to it.");

  std::vector<std::uint8_t> scored(mask.size(), 0);
  const std::int64_t plane = grid.size[0] * grid.size[1];
  for (const std::int64_t k : input.testSlices)
    std::copy_n(mask.begin() + k * plane, plane, scored.begin() + k * plane);

  EvaluationReport report;
  report.protocol = "held-out";
  report.caseName = caseName(c);
  report.peak = intensityRange(input.truth);
  report.range = formatted("PSNR peak: the truth's maximum minus minimum, %g.", report.peak);

  const auto add = [&](const std::string& name, const std::function<Volume()>& method) {
    const TimedVolume run = runMethod(name, options, method);
    const Quality quality =
        pooledQuality(*run.volume, input.truth, mask, report.peak, input.testSlices, options.stop);
    report.voxels = quality.voxels;
    MethodScore score;
    score.name = name;
    score.psnr = score.pooledPsnr = quality.psnr;
    score.ssim = quality.ssim;
    score.seconds = run.seconds;
    score.cpuSeconds = run.cpuSeconds;
    score.peakMemory = run.peakMemory;
    if (options.keepVolumes) score.volume = run.volume;
    if (name == "gaussians" && report.uncertainty)
      score.intervals = intervalScore(*run.volume, input.truth, scored, *report.uncertainty,
                                      report.uncertainty->deviation, estimateNoise(input.truth));
    report.methods.push_back(std::move(score));
  };
  const std::span<const Stack> first(input.stacks.data(), 1);
  const auto interpolated = [&](Interpolation kind) {
    return [&, kind] { return averageUpsampled(first, grid, kind, threads, options.stop); };
  };
  if (options.gaussians)
    add("gaussians", [&] { return reconstructGaussians(input.stacks, grid, options, report); });
  add("linear", interpolated(Interpolation::Linear));
  add("cubic", interpolated(Interpolation::Cubic));
  add("lanczos", interpolated(Interpolation::Lanczos));
  if (several) {
    add("average",
        [&] { return averageUpsampled(input.stacks, grid, Interpolation::Cubic, threads, options.stop); });
    report.notes.push_back(
        "linear, cubic and lanczos see the axial stack alone; average is the mean of all stacks, "
        "each interpolated by cubic B-splines.");
  }
  if (c.kind != HeldOutCase::Kind::KeepEvery)
    add("backprojection", [&] {
      return backProjectionBaseline(input.stacks, grid, {.threads = threads, .stop = options.stop});
    });

  if (options.totalVariation)
    add("totalvariation",
        [&] { return totalVariation(input.stacks, grid, {.threads = threads, .stop = options.stop}); });

  const std::string where =
      c.kind == HeldOutCase::Kind::KeepEvery
          ? formatted("the %s slices between the kept ones, every %s, %s mm apart (no method saw them in any "
                      "plane)",
                      planeName(planeAcross(grid, 2)),
                      c.factor == 2   ? "2nd"
                      : c.factor == 3 ? "3rd"
                                      : (std::to_string(c.factor) + "th").c_str(),
                      lengthText(c.factor * grid.spacing[2]).c_str())
          : "the whole volume that the thick slices cover (no method saw the thin slices)";
  report.samples =
      formatted("%s voxels: %s, inside %s.", countText(report.voxels).c_str(), where.c_str(),
                options.mask ? "the mask of the reconstruction"
                             : "the body mask of the truth (above Otsu's threshold, holes filled)");
  if (options.keepVolumes) {
    report.truth = std::make_shared<const Volume>(std::move(input.truth));
    report.input = std::make_shared<const std::vector<Stack>>(std::move(input.stacks));
  }
  return report;
}

} // namespace innergs
