#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Render/Render.h"

#include <optional>

namespace innergs {

/// Sets the residual of a fitted field to what its Gaussians miss of the slices, by back-projection; leaves
/// it where they miss nothing. predictions: of single scans, as thin slices; a share of the mean of what the
/// Gaussians miss of them is added first, its noise taken out (as from `predictions`). noise (standard
/// deviation) and range: in the slices' units. options: to render the field. Returns the mean squared error
/// with it, in normalised intensity. Throws Error(Cancelled).
double refineToSlices(GaussianField& field, std::span<const Stack> slices, double noise,
                      const ValueRange& range, RenderOptions options, ThreadPool& pool,
                      std::span<Stack> predictions = {}, double share = 0);

/// The same for thin slices, of one scan or several: what the Gaussians miss at the scans' own voxels,
/// without the noise that a Wiener filter finds in the mean of the scans.
double refineToThinScans(GaussianField& field, std::span<const Stack> scans, double noise,
                         RenderOptions options, ThreadPool& pool);

/// A volume and its share in an average.
struct WeightedVolume {
  Volume volume;
  double share = 0;
};

/// The same for what they miss of a prediction, without its noise, on the prediction's grid, averaged with
/// another volume of that grid, if any. `predicted` becomes that average; the error returned is its error
/// on the scans it was predicted from.
double refineToPrediction(GaussianField& field, Stack& predicted, const std::optional<WeightedVolume>& other,
                          std::span<const Stack> scans, double noise, RenderOptions options,
                          ThreadPool& pool);

} // namespace innergs
