#pragma once
#include "Core/Fit/Proxy.h"
#include "Core/Settings/Settings.h"

namespace innergs {

/// Layout of the initial Gaussians.
struct InitialisationPlan {
  Initialisation kind = Initialisation::Adaptive;
  std::int64_t gaussians = 0; // at most; all of them where the proxy is covered
  bool equalCounts = false;   // even grid, as many along each axis of the covered box (paper: 42×42×42)
  double scaleFactor = 0.5;   // σ₀ in units of the local spacing
  double evenShare = 0.15;    // share of the budget spread evenly; the rest follows the structure
  double exponent = 0.75;     // density ∝ structure^exponent
  double layerSpacing =
      0; // > 0: layered start with one layer per slice, this far apart (mm) along the model's third axis
  double layerSigma = 0; // σ along the third axis in a layered start (mm)
};

/// Fills field.gaussians in Morton order; the same seed gives the same field.
void initialise(GaussianField& field, const ProxyVolume& proxy, const InitialisationPlan& plan,
                std::uint64_t seed, ThreadPool& pool);

/// The share (0 to 1) of a start over all finite voxels that lies where the stacks observe, or little more
/// than half a Gaussian distance from there. With that share of the Gaussians, a part is fitted as well as
/// within the whole, if as many of them follow its structure.
struct ReachedShare {
  double gaussians = 1; // at least `volume`
  double volume = 1;
};
/// `volume`: of all finite voxels, mm³; `voxel`: mm, the finest relevant size. Throws Error(Cancelled) if the
/// pool is stopped.
ReachedShare reachedShare(std::span<const Stack> stacks, const IntensityMap& map,
                          const InitialisationPlan& start, double volume, double voxel, ThreadPool& pool);

/// Structure measure that sets the density: 0.5·|∇I| + |second differences|, smoothed (Docs/method.md);
/// computed from covered voxels only, 0 elsewhere.
std::vector<float> structureMeasure(const ProxyVolume& proxy, ThreadPool& pool);

/// Order by position along a Morton curve, so that neighbours in space are neighbours in memory. Returns the
/// permutation (new → old).
std::vector<std::uint32_t> mortonOrder(std::span<const Gaussian> gaussians);
std::vector<Gaussian> inMortonOrder(std::vector<Gaussian> gaussians);

} // namespace innergs
