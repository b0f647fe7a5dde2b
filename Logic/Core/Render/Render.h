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
  bool scannerUnits = true;               // applies the field's intensity map and clamps to its range
  bool bounded = true;                    // false: as the fit sees the field, ignoring support and range
  std::span<const float> values; // per Gaussian, replaces intensity and slope: renders any other channel
  std::stop_token stop;          // when stopped, throws Error(Cancelled)
  std::shared_ptr<FieldDevice> device; // holds the same field; if null or if it fails: the CPU
};

/// The field at every voxel centre of a grid (thin: no slice profile). Any grid: oblique, single-slice,
/// left-handed.
/// Outside the field's domain I = 0; outside the support of a masked field, its fill value. Alpha blending:
/// as slices normal to the grid's third axis.
Volume render(const GaussianField& field, const GridGeometry& geometry, const RenderOptions& options = {});

/// The field as a scanner would see it: on the stack's grid, integrated over its slice profile; the fill
/// value where a voxel's centre lies outside the support.
Volume renderStack(const GaussianField& field, const Stack& stack, const RenderOptions& options = {});

/// Instruction sets that this processor supports, best first, then "scalar".
std::vector<std::string> instructionSets();

} // namespace innergs
