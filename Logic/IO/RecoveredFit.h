#pragma once
#include "Core/Model/Model.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Settings/Settings.h"

#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// Where a fit stood when something else than a person's cancel stopped it (its scene was closed, its program
/// ended; of a moving scan also a cancel): a model file to go on from, and what else that takes.
struct RecoveredFit {
  std::filesystem::path file;
  std::string inputs, mask;          // names, as in ModelNotes; no mask: ""
  Settings settings;                 // as they were asked for
  int iteration = 0, iterations = 0; // done, and of how many, over all ensemble members
  bool moving = false;               // of a moving scan: iterations are the refinement's steps
  double interval = 0;               // of a moving scan: s from frame to frame as it was given; 0: it was not
};

/// Writes the model under a unique name into the folder, which is created if needed, for this user alone;
/// only the newest ten stay there. Returns the file. Throws Error(Io).
std::filesystem::path writeRecoveredFit(const Model& model, const RecoveredFit& about,
                                        const std::filesystem::path& folder);

/// The same for a moving scan's. `fit` must have a state.
std::filesystem::path writeRecoveredFit(const StoppedDynamicFit& fit, const RecoveredFit& about,
                                        const std::filesystem::path& folder);

/// The same for where a moving scan's reconstruction stands, or ended: completes `about` with its steps and
/// file; leaves it without a file where there is nothing to go on from. Throws Error(Io).
void writeStoppedFit(const DynamicResult& result, RecoveredFit& about, const std::filesystem::path& folder);

/// Removes a file that a fit went on from, if it lies in the folder: there is a newer state.
void dropRecoveredFit(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Those in the folder, newest first; other files are passed over.
std::vector<RecoveredFit> recoveredFits(const std::filesystem::path& folder);

} // namespace innergs
