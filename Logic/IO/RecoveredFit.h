#pragma once
#include "Core/Model/Model.h"
#include "Core/Settings/Settings.h"

#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// Where a fit stood when something else than a person's cancel stopped it (its scene was closed, its program
/// ended): a model file to go on from, and what else that takes.
struct RecoveredFit {
  std::filesystem::path file;
  std::string inputs, mask;          // names, as in ModelNotes; no mask: ""
  Settings settings;                 // as they were asked for
  int iteration = 0, iterations = 0; // done, and of how many, over all ensemble members
};

/// Writes the model under a name of its own into the folder, which is made if need be, for this user alone;
/// only the newest ten stay there. Returns the file. Throws Error(Io).
std::filesystem::path writeRecoveredFit(const Model& model, const RecoveredFit& about,
                                        const std::filesystem::path& folder);

/// Those in the folder, newest first; other files are passed over.
std::vector<RecoveredFit> recoveredFits(const std::filesystem::path& folder);

} // namespace innergs
