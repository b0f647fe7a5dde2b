#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/Labelmap.h"
#include "Core/Image/Volume.h"

#include <functional>
#include <span>
#include <stop_token>

namespace innergs {

struct FeatureQueryOptions {
  int threads = 0;                      // 0 = all cores
  std::stop_token stop;                 // stopped: throws Error(Cancelled)
  std::function<void(double)> progress; // fraction done
  /// On a grid, [voxel][3]: from the tissue's place to where it was when the features were learned, mm,
  /// LPS. Empty: nothing moved.
  std::function<std::vector<float>(const GridGeometry&)> displacement;
};

/// The classes on a grid, decoded from a model's features.
struct ClassImage {
  GridGeometry geometry;
  std::vector<std::uint16_t> classes; // the likeliest class of each voxel, 0 outside the field
};

/// The voxels of a grid that may not be background: visit(voxel, its classes, their
/// probabilities), a row along I by one thread; chunkDone(first plane, past the last plane) after every chunk
/// of planes, on the caller's thread. Throws Error(Geometry | Cancelled).
using DecodedVisit = std::function<void(std::int64_t voxel, std::span<const std::uint16_t> classes,
                                        const float* probabilities)>;
void decodeGrid(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                const FeatureQueryOptions& options, const DecodedVisit& visit,
                const std::function<void(std::int64_t, std::int64_t)>& chunkDone = {});

/// The latents F of a field on a grid, [voxel][channel]: F = Σ w p f / (Σ w p + ε). Throws Error(Geometry
/// | Cancelled).
std::vector<float> renderFeatures(const GaussianField& field, const FeatureModel& features,
                                  const GridGeometry& geometry, const FeatureQueryOptions& options = {});

/// The classes at every voxel of any grid: oblique, one slice, finer than what was labelled. Throws
/// Error(Geometry | Cancelled).
ClassImage classify(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                    const FeatureQueryOptions& options = {});

} // namespace innergs
