#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// One case of the held-out protocol (H). What is held out is held out in every plane.
struct HeldOutCase {
  enum class Kind {
    KeepEvery, // keeps every factor-th slice and tests on the others
    Thick,     // thick slices, each the mean of `factor` thin ones
    Orthogonal // `stacks` thick stacks (axial, coronal, sagittal), with slices of `factor` voxels
  };
  Kind kind = Kind::KeepEvery;
  int factor = 4;   // keep-every: 2…64, or 0: chosen by usualGap(); thickness in voxels: 2…64
  int stacks = 2;   // orthogonal: 2 or 3
  double noise = 0; // standard deviation added to the input, image units
  int axis = -1;    // grid axis that counts the slices; -1: the axial ones (the only option for orthogonal)
};

/// The keep-every factor for a scan at its acquired resolution: 4, or 2 if its slices are clearly farther
/// apart than its pixels or few, so that the test stays close to the actual task. axis as in HeldOutCase.
int usualGap(const GridGeometry& scan, int axis = -1);
/// The grids of that case without voxels, for estimates: the kept slices and, as output, the scan's own
/// grid. factor and axis as in HeldOutCase.
ReconstructionInput keptOutline(const GridGeometry& scan, int factor, int axis = -1);

EvaluationInput heldOutInput(const Volume& volume, const HeldOutCase& heldOutCase, std::uint64_t seed = 1);

/// Throws Error(InvalidArgument) if the volume is too small for the case, NoData if it is constant.
EvaluationReport evaluateHeldOut(const Volume& volume, const HeldOutCase& heldOutCase,
                                 const EvaluationOptions& options = {});

} // namespace innergs
