#pragma once
#include "Core/Fit/Trainer.h"

namespace innergs {

/// The properties of the input that the choices depend on.
struct DataTraits {
  double voxel = 1;        // finest in-plane spacing of all stacks, mm
  double gap = 1;          // largest distance between slices of a stack, mm
  double thickness = 0;    // largest slice thickness that blurs, mm (0: thin slices)
  double noise = 0;        // standard deviation, normalised intensity
  double disagreement = 0; // root mean square of what slices that moved miss of the other scans, likewise; 0:
                           // unknown
  int stacks = 1;
  std::int64_t samples = 0; // finite observed voxels
  double volume = 0;        // of the finite voxels, observed or not, mm³; overlapping stacks count once
  ReachedShare reached;     // share of a full start that affects what is observed
  bool region = false;      // cut out of larger scans
  bool posed = false;       // slices have poses
  bool adjoining = false;   // several stacks of distant slices that mostly lie beside each other
  bool cubes = false;       // one connected stack of thin slices with nearly cubic voxels
  /// A single stack whose slices are clearly farther apart than its pixels: the fit must bridge the gaps.
  bool singleAnisotropic() const { return stacks == 1 && gap > 1.4 * voxel; }
  bool superResolution() const { return gap > 1.4 * voxel; }
};
/// Whether the fit of these data starts with a prediction of what lies between the slices; the field is then
/// fitted to an isotropic volume.
bool predicts(const Settings& settings, const DataTraits& traits);
/// Whether a fit without a prediction is completed by a residual grid: of thick slices, and of thin ones that
/// lie close together (normalised blending), unless slices came with poses.
bool addsResidual(const Settings& settings, const DataTraits& traits);
/// The largest noise (standard deviation) of the stacks, in units of the map.
double noiseOf(std::span<const Stack> stacks, const IntensityMap& map);
/// The traits that the grids alone determine: voxel, gap, thickness, stacks, volume (as if all were
/// observed), posed, adjoining, cubes; and a typical noise.
DataTraits geometryTraits(std::span<const Stack> stacks);
/// These traits where the slices will be found to have moved; with a typical disagreement.
DataTraits withMovedSlices(DataTraits traits);
/// All traits except `reached` and `disagreement`; independent of the order of the stacks.
DataTraits measureTraits(std::span<const Stack> stacks, const IntensityMap& map);

/// Derives all parameters of a fit from settings and data, and fills the optionals of `settings`.
/// Super-resolution fits several members: fields with shifted or redrawn starts, fitted independently and
/// merged into one normalised field. That field is close to their average, so it leaves out what each invents
/// where the data say nothing. settings.gaussians is the budget of one member. Docs/benchmarks.md has the
/// measurements behind the constants. Throws Error(InvalidArgument) if the settings are impossible with these
/// data.
FitPlan makePlan(Settings& settings, const DataTraits& traits);

/// Maps the intensities of a fit to [0, 1]: offset = smallest, scale = largest − smallest finite observed
/// value, without outliers (0.01 % on each side).
IntensityMap chooseIntensityMap(std::span<const Stack> stacks);

} // namespace innergs
