#pragma once
#include "Core/Image/Stack.h"
#include "Core/Model/GaussianField.h"
#include "Core/Settings/Selection.h"

#include <memory>
#include <stop_token>

namespace innergs {

class FieldDevice;

struct RenderOptions {
  int threads = 0;                        // 0 = all cores
  std::string instructionSet;             // "" = best available
  Selection selection = Selection::Exact; // of slices; points have no candidates to select
  bool scannerUnits = true;               // apply the field's intensity map, and stay within its range
  bool bounded = true;           // false: as the fit sees the field, with neither its support nor its range
  std::span<const float> values; // per Gaussian, replaces intensity and slope: renders any other channel
  std::stop_token stop;          // stopped: throws Error(Cancelled)
  std::shared_ptr<FieldDevice> device; // that holds the same field; the CPU where null, and where it fails
};

/// The field at every voxel centre of a lattice (thin: no slice profile). Any lattice: oblique, one slice,
/// left-handed.
/// Outside the field's domain I = 0; outside the support of a masked one its fill value. Alpha blending: as
/// slices along the lattice's third axis.
Volume render(const GaussianField& field, const GridGeometry& geometry, const RenderOptions& options = {});

/// The field as a scanner would see it: lattice of the stack, integrated over its slice profile; the fill
/// value where a voxel's centre lies outside the support.
Volume renderStack(const GaussianField& field, const Stack& stack, const RenderOptions& options = {});

/// The field at points (LPS mm). Alpha blending: each on a slice across the model's third axis.
std::vector<float> renderPoints(const GaussianField& field, std::span<const Vec3> points,
                                const RenderOptions& options = {});

/// Instruction sets that this processor can run, best first, then "scalar".
std::vector<std::string> instructionSets();

} // namespace innergs
