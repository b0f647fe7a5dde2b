#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/Labelmap.h"

#include <functional>
#include <memory>
#include <stop_token>

namespace innergs {

class FeatureDevices;

/// A class of a labelmap: its value there and its name.
struct SegmentName {
  std::uint16_t label = 0;
  std::string name;
};

/// Labels to learn from, and what they are called.
struct NamedLabels {
  Labelmap labels;
  std::vector<SegmentName> names;
};

struct FeatureTraining {
  int channels = 16;  // of a latent: 8, 16 or 32
  int iterations = 0; // over the voxels near borders of classes; 0: as the labels need
  int threads = 0;    // 0 = all cores
  std::uint64_t seed = 1;
  std::function<void(double)> progress;    // fraction done
  std::stop_token stop;                    // stopped: throws Error(Cancelled)
  std::shared_ptr<FeatureDevices> devices; // for the iterations; null: the CPU
};

/// Learns latents for the Gaussians of a field, whose geometry stays as it is, from a labelmap on any
/// grid: runs completeLabels() on the field's own intensities, minimises the cross-entropy of the decoded
/// latents by Adam, and keeps what they still miss of the labelled slices as a residual. Labels without a
/// name are called "Segment 3"; named ones without a voxel become no class. Bit-identical at any number of
/// threads; a device, which may fail, gives other last bits. Throws Error(NoData) without a label inside the
/// field, Error(Geometry | InvalidArgument | Cancelled).
FeatureModel trainFeatures(const GaussianField& field, const Labelmap& labels,
                           const std::vector<SegmentName>& names, const FeatureTraining& training = {});

} // namespace innergs
