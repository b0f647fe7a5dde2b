#pragma once
#include "CLI/ReconstructOptions.h"

#include <nlohmann/json.hpp>

namespace innergs::cli {

nlohmann::ordered_json toJson(const GridGeometry& geometry);
nlohmann::ordered_json toJson(const Settings& settings);
/// Versions of InnerGS and of what it runs on.
nlohmann::ordered_json versions();

/// What a run was given, measured before the stacks move into the job.
struct ScanRecord {
  std::string file;
  GridGeometry geometry;
  double thickness = 0;
  SliceProfile profile = SliceProfile::Box;
  std::int64_t nonFiniteVoxels = 0;
};
ScanRecord record(const std::string& file, const Stack& stack);

/// One sentence on what the quality figure means.
std::string qualitySentence(const ReconstructionResult& result);

/// The report of `innergs reconstruct --report`; a figure that does not exist is null.
nlohmann::ordered_json reconstructReport(const ReconstructOptions& options,
                                         const std::vector<ScanRecord>& scans,
                                         const ReconstructionResult& result,
                                         const std::vector<std::pair<std::string, double>>& phases);

} // namespace innergs::cli
