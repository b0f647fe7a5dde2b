#pragma once
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// Identifies the settings and the input that a fit's state belongs to: only a model with the same key
/// continues bit for bit.
std::string settingsKey(const Settings& settings, const std::string& fingerprint);

/// Throws Error(FileFormat) if a model's state cannot belong to a fit of this many iterations (lengths,
/// counts, moments out of range).
void checkResumable(const Model& model, int iterations);

} // namespace innergs
