#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/Labelmap.h"
#include "Core/Image/Volume.h"

#include <functional>
#include <span>
#include <stop_token>

namespace innergs {

struct FeatureQueryOptions {
  int threads = 0;                             // 0 = all cores
  std::stop_token stop;                        // stopped: throws Error(Cancelled)
  std::function<void(double)> progress;        // fraction done
  std::span<const std::vector<int>> scoreSets; // sets of classes whose probability is wanted
};

/// A lattice as a model's features decode it.
struct ClassImage {
  GridGeometry geometry;
  std::vector<std::uint16_t> classes;     // the likeliest class of each voxel, 0 outside the field
  std::vector<std::vector<float>> scores; // per score set the probability of its classes
};

/// The latents F of a field on a lattice, [voxel][channel]: F = Σ w p f / (Σ w p + ε). Throws Error(Geometry
/// | Cancelled).
std::vector<float> renderFeatures(const GaussianField& field, const FeatureModel& features,
                                  const GridGeometry& geometry, const FeatureQueryOptions& options = {});

/// The classes at every voxel of any lattice: oblique, one slice, finer than what was labelled. Throws
/// Error(Geometry | Cancelled).
ClassImage classify(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                    const FeatureQueryOptions& options = {});

} // namespace innergs
