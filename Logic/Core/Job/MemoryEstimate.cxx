#include "Core/Job/MemoryEstimate.h"

#include "Core/Base/Quantities.h"
#include "Core/Fit/Plan.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/PredictionPlan.h"
#include "Core/Job/SimulatedFit.h"
#include "Core/Prediction/CandidateGrid.h"
#include "Core/Render/Projected.h"
#include "Core/Uncertainty/ErrorCurve.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

std::int64_t resultBytes(const ReconstructionInput& fit) {
  const GridGeometry grid = fit.outputGrid ? *fit.outputGrid : defaultOutputGrid(fit.stacks);
  return grid.voxelCount() * static_cast<std::int64_t>(sizeof(float));
}

/// Size of the samples that a fit holds, and of the buffers for the largest grid.
struct GridBytes {
  double voxels = 0;  // of the stacks, padded
  double samples = 0; // fitted, padded: with all axes every voxel counts three times
  double largest = 0; // points of the largest grid, sub-planes and padding included
  double planes = 1;  // of the grid with the most planes
  double points = 1;  // of a pixel, at most
};

GridBytes gridsOf(std::span<const Stack> stacks, const Settings& settings, double voxel, bool allAxes) {
  GridBytes sum;
  for (const Stack& stack : stacks) {
    const GridGeometry& g = stack.image.geometry;
    const auto planes =
        profileQuadrature(stack.profile, effectiveThickness(stack), std::min(g.spacing[0], g.spacing[1]));
    const double width = pixelWidth(stack, stacks, settings);
    const auto edge = static_cast<double>(pixelQuadrature(stack.profile, width, voxel).offset.size());
    sum.points = std::max(sum.points, edge * edge);
    for (int axis = 2; axis >= (allAxes ? 0 : 2); --axis) {
      const std::int64_t rows = g.size[axis == 0 ? 1 : 0];
      const double padded = static_cast<double>((rows + 15) / 16 * 16) / static_cast<double>(rows) *
                            static_cast<double>(g.size[0]) * static_cast<double>(g.size[1]) *
                            static_cast<double>(g.size[2]);
      const double perSlice = static_cast<double>(planes.offset.size()) * edge * edge;
      if (axis == 2) sum.voxels += padded;
      sum.samples += padded;
      sum.largest = std::max(sum.largest, padded * perSlice);
      sum.planes = std::max(sum.planes, static_cast<double>(g.size[axis]) * perSlice);
    }
  }
  return sum;
}

/// What alpha blending's backward pass keeps: for every grid, moments for every plane that a Gaussian
/// reaches, estimated from the width at which `count` of them fill the volume; for the current grid, three
/// numbers per voxel.
double alphaScratch(const FitPlan& plan, const DataTraits& traits, const GridBytes& grids, double count,
                    double views) {
  const double sigma = plan.start.scaleFactor * std::cbrt(traits.volume / count);
  const double planes = std::min(grids.planes, 2 * (2 * plan.cutoff * sigma / traits.voxel + 1));
  return 32 * count * planes * views + 12 * grids.largest;
}

/// While a prediction from a scan's slices on a grid is made: two candidates and their corrections, or a
/// field's own fit.
double predictingBytes(const Stack& scan, const GridGeometry& grid, const Settings& settings) {
  const double slices = static_cast<double>(scan.image.geometry.voxelCount()),
               voxels = static_cast<double>(grid.voxelCount());
  double candidates = 16 * voxels;
  const bool mayAverage = fieldShareOfNoisy(scan, settings, 1, grid.voxelCount()) > 0;
  if (mayAverage || (settings.prediction != PredictionKind::Interpolation && triesField(settings, voxels))) {
    ReconstructionInput field;
    field.stacks = {scan};
    field.outputGrid = grid;
    candidates = std::max(candidates,
                          static_cast<double>(estimateMemory(field, fieldSettings(settings))) + 4 * voxels);
  }
  return candidates + 40 * slices;
}

/// With predictions from each of several scans: these, one being made, and then what a field misses of them.
double mixingBytes(const ReconstructionInput& input, const Settings& settings) {
  const GridGeometry domain = dataDomain(input.stacks);
  double predicted = 0, making = 0;
  for (const Stack& scan : input.stacks) {
    const GridGeometry grid = candidateGrid(scan.image.geometry, domain);
    predicted += 4 * static_cast<double>(grid.voxelCount());
    making = std::max(making, predictingBytes(scan, grid, scanSettings(settings)));
  }
  return predicted + std::max(predicted, making);
}

/// With a prediction: the fit to it, as to thin slices, together with the slices; and while it is made, what
/// predictingBytes() counts.
std::int64_t predictedMemory(const ReconstructionInput& input, const Settings& settings, Settings filled,
                             const GridGeometry& grid) {
  const ReconstructionInput thin = predictionOutline(input, grid);
  const GridGeometry& joined = thin.stacks.front().image.geometry;
  filled.prediction = PredictionKind::None;
  const double slices = voxelsOf(input.stacks);
  const double fit = static_cast<double>(estimateMemory(thin, filled)) + 5 * slices;
  double predicting = 0;
  for (const Stack& scan : input.stacks)
    predicting =
        std::max(predicting, predictingBytes(scan, candidateGrid(scan.image.geometry, joined), settings));
  if (input.stacks.size() > 1) // sums and weights, of predictions and of fields
    predicting += 16 * static_cast<double>(joined.voxelCount()) + 5 * slices;
  return static_cast<std::int64_t>(std::max(fit, predicting));
}

/// While the result is kept: the second fit, then the simulation that the uncertainty needs, then the
/// uncertainty itself.
std::int64_t judgedMemory(const ReconstructionInput& input, const Settings& settings, std::int64_t fit) {
  if (heldOutFraction(input) == 0) return fit;
  const std::int64_t result = resultBytes(input);
  if (!input.uncertainty) return result + fit;
  const double voxels = voxelsOf(input.stacks);
  // The stacks where they lie, and what is seen of held-out slices, once whole and once in halves.
  const double seen = heldOutFraction(input) * voxels;
  const auto kept =
      static_cast<std::int64_t>(5 * voxels + seen * (sizeof(HeldOutValue) + 2 * sizeof(HeldOutError)));
  const SimulatedFit simulated = simulatedOutline(input, settings);
  const std::int64_t cube =
      6 * simulated.input.outputGrid->voxelCount() * static_cast<std::int64_t>(sizeof(float));
  return result + kept +
         std::max(
             {fit,
              result /* the second volume */ + cube + estimateMemory(simulated.input, simulated.settings),
              4 * result /* details, deviation, distances and what was measured */});
}

} // namespace

std::int64_t estimateMemory(const ReconstructionInput& input, const Settings& settings) {
  if (input.stacks.empty()) return 0;
  DataTraits traits = geometryTraits(input.stacks);
  traits.reached.gaussians = traits.reached.volume =
      maskedShare(input, traits.volume, std::max(traits.gap, 3 * traits.voxel));
  if (predicts(settings, traits)) {
    Settings filled = settings;
    makePlan(filled, traits);
    const std::int64_t fit = predictedMemory(
        input, settings, filled, input.outputGrid ? *input.outputGrid : defaultOutputGrid(input.stacks));
    return judgedMemory(input, settings, fit);
  }
  const GridGeometry domain = dataDomain(input.stacks);
  const Vec3 extent = domain.extent();
  const double proxy = extent[0] * extent[1] * extent[2] / std::pow(traits.voxel, 3);
  const bool mayMove = correctsSlices(settings, input.stacks);
  Settings filled = settings;
  const FitPlan plan = makePlan(filled, mayMove ? withMovedSlices(traits) : traits);
  const GridBytes grids = gridsOf(input.stacks, settings, traits.voxel, plan.allAxes);
  const double gaussians = static_cast<double>(
      plan.densify.every > 0 ? std::max(*filled.gaussians, *filled.maxGaussians) : *filled.gaussians);
  const GridGeometry grid = input.outputGrid ? *input.outputGrid : defaultOutputGrid(input.stacks);
  const double axes = plan.allAxes ? 5 * grids.voxels : 0; // slices along another axis, one axis at a time
  const double copies =
      grids.voxels * 5 /* the job's own stacks */ + grids.samples * 5 /* targets and weights */ + axes;
  const double merged = gaussians * filled.ensembleSize.value_or(1) * (2 * 64.0 + sizeof(Projected));
  const double views = plan.allAxes ? 3 : static_cast<double>(input.stacks.size());
  const double alpha =
      filled.blending == Blending::Alpha ? alphaScratch(plan, traits, grids, gaussians, views) : 0;
  const double densify = plan.densify.every > 0 ? gaussians * (3 * 64.0 + 16) : 0; // while sorting them
  const double fit =
      merged + grids.largest * 8 /* W, N */ +
      gaussians * (4 * 64.0 + std::max(views, grids.points) * (sizeof(Projected) + 16.0) + 16) + alpha +
      densify;
  const double bridged = heldOutFraction(input) > 0 ? grids.voxels * 5 : 0; // see startStacks()
  const double start = bridged + proxy * 13 /* values, coverage, density and its smoothing */;
  const double output = static_cast<double>(grid.voxelCount()) * 4 + 64e6;
  const double residual =
      addsResidual(settings, traits) ? static_cast<double>(domain.voxelCount()) * 16 + grids.samples * 12 : 0;
  // Beside the refined field's residual grid.
  const double mixing = predictsEach(settings, traits, input.stacks, !input.masks.empty())
                            ? residual + mixingBytes(input, settings)
                            : 0;
  const double motion = mayMove ? static_cast<double>(sliceMotionMemory(input.stacks)) : 0;
  return judgedMemory(
      input, settings,
      static_cast<std::int64_t>(copies + std::max({fit, start, residual, mixing, motion}) + output));
}

std::string memoryRefusal(std::int64_t needed, std::int64_t available) {
  if (available <= 0 || needed <= available) return {};
  return "The reconstruction needs about " + bytesText(static_cast<double>(needed)) +
         " of memory, but only " + bytesText(static_cast<double>(available)) +
         " is available: choose a smaller region, a coarser output or fewer Gaussians.";
}

MemoryNeed memoryNeed(std::span<const ReconstructionInput> fits, const Settings& settings,
                      std::int64_t available) {
  MemoryNeed need;
  std::int64_t kept = 0;
  for (std::size_t n = 0; n < fits.size(); ++n) {
    if (fits[n].stacks.empty()) continue;
    const std::int64_t bytes = kept + estimateMemory(fits[n], settings);
    need.bytes = std::max(need.bytes, bytes);
    kept += resultBytes(fits[n]);
    if (!need.refusal.empty() || memoryRefusal(bytes, available).empty()) continue;
    need.refusal = n == 0 ? memoryRefusal(bytes, available)
                          : "Judging the quality needs about " + bytesText(static_cast<double>(bytes)) +
                                " of memory, but only " + bytesText(static_cast<double>(available)) +
                                " is available: turn it off, or choose a smaller region, a coarser output "
                                "or fewer Gaussians.";
  }
  return need;
}

} // namespace innergs
