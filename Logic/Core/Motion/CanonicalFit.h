#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Device/Devices.h"
#include "Core/Fit/Plan.h"
#include "Core/Model/GaussianField.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Kernels.h"

#include <functional>

namespace innergs {

/// All parameters of the fit to one frame of a dynamic scan.
struct CanonicalPlan {
  std::int64_t gaussians = 8'000;
  int iterations = 80;
  double margin = 6;   // around the frame, also covered by Gaussians; in units of the finest spacing
  double cutoff = 2.5; // Mahalanobis radius
};

/// The plan of that fit; voxel: finest spacing, mm.
FitPlan fitPlan(const CanonicalPlan& plan, double voxel);

/// A frame as samples at its voxel centres; non-finite voxels get weight 0. Keeps all planes, so that every
/// frame has the same grid.
Observation observeFrame(const std::vector<float>& frame, const GridGeometry& geometry,
                         const Affine3& modelToWorld, const IntensityMap& map);

/// The same for all frames of a series. Throws Error(Cancelled) when the pool is stopped.
std::vector<Observation> observeFrames(const TimeSeries& series, const Affine3& modelToWorld,
                                       const IntensityMap& map, const ThreadPool& pool);

/// Replaces a field's Gaussians by ones fitted to a frame whose edge voxels are repeated in a margin. Returns
/// the grid of the frame with its margin. report: share done, mean squared error (normalised intensity²).
/// device: where to fit; null: the CPU. Throws Error(Cancelled) when the pool is stopped.
GridGeometry fitCanonical(GaussianField& field, const std::vector<float>& frame, const GridGeometry& geometry,
                          const IntensityMap& map, const CanonicalPlan& plan, std::uint64_t seed,
                          const KernelSet& kernels, ThreadPool& pool,
                          const std::function<void(double share, double mse)>& report,
                          DeviceChoice* device = nullptr);

/// Corners of the box of a grid's voxel centres, mm, model frame.
std::array<Vec3, 2> boxInModel(const GridGeometry& grid, const Affine3& modelToWorld);

} // namespace innergs
