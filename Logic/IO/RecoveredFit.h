#pragma once
#include "Core/Model/Model.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Settings/Settings.h"

#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// The state of a fit that was stopped by something other than the user's cancel (its scene was closed, the
/// program ended; for a dynamic scan also by a cancel): a model file to resume from, and what else resuming
/// takes.
struct RecoveredFit {
  std::filesystem::path file;
  std::string inputs, mask;          // names, as in ModelNotes; no mask: ""
  Settings settings;                 // as requested
  int iteration = 0, iterations = 0; // done and in total, over all ensemble members
  bool dynamic = false;              // of a dynamic scan: iterations are the refinement's steps
  double interval = 0;               // of a dynamic scan: s between frames, if given; 0: it was not
};

/// Writes the model under a unique name to the folder, which is created if needed, accessible only to this
/// user; keeps only the newest ten there. Returns the file. Throws Error(Io).
std::filesystem::path writeRecoveredFit(const Model& model, const RecoveredFit& about,
                                        const std::filesystem::path& folder);

/// The same for a dynamic scan's. `fit` must have a state.
std::filesystem::path writeRecoveredFit(const StoppedDynamicFit& fit, const RecoveredFit& about,
                                        const std::filesystem::path& folder);

/// The same for the current or final state of a dynamic scan's reconstruction: completes `about` with its
/// steps and file; leaves it without a file if there is nothing to resume from. Throws Error(Io).
void writeStoppedFit(const DynamicResult& result, RecoveredFit& about, const std::filesystem::path& folder);

/// Removes a file that a fit was resumed from, if it lies in the folder: a newer state exists.
void dropRecoveredFit(const std::filesystem::path& file, const std::filesystem::path& folder);

/// The fits in the folder, newest first; skips other files.
std::vector<RecoveredFit> recoveredFits(const std::filesystem::path& folder);

} // namespace innergs
