#pragma once
#include "Evaluation/Protocols.h"
#include "Evaluation/SimulatedStacks.h"

namespace innergs {

/// Reconstructs simulated thick stacks and scores every method on the truth, inside its body mask and at
/// least 8 mm from the faces of what was scanned: PSNR and SSIM after removing one gain and, where slices
/// moved, one rigid transform, as no method can know either. Where that transform puts the truth, the
/// Gaussians are rendered and other volumes interpolated by cubic B-splines. Where slices move, the Gaussians
/// are also fitted without correcting for it ("uncorrected"). Throws Error(InvalidArgument) when the volume
/// is too small for the case, NoData when it is constant or has no body there, Error(Cancelled).
EvaluationReport evaluateStacks(const Volume& volume, const StacksCase& stacksCase,
                                const EvaluationOptions& options = {});

} // namespace innergs
