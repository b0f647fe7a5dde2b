#pragma once
#include "CLI/ReconstructOptions.h"

#include <nlohmann/json.hpp>

namespace innergs::cli {

nlohmann::ordered_json toJson(const GridGeometry& geometry);
/// dynamic: the settings of dynamic scans, else those of all other fits.
nlohmann::ordered_json toJson(const Settings& settings, bool dynamic = false);
/// Where a fit ran.
nlohmann::ordered_json toJson(const DeviceUse& device);
/// Versions of InnerGS and of its dependencies.
nlohmann::ordered_json versions();

/// The input of a run, recorded before the stacks move into the job.
struct ScanRecord {
  std::string file;
  GridGeometry geometry;
  double thickness = 0;
  SliceProfile profile = SliceProfile::Box;
  std::int64_t nonFiniteVoxels = 0;
  std::string thicknessFrom; // where it is said
  std::string sliceOrder;    // in which the slices were acquired; empty: not known
};
ScanRecord record(const std::string& file, const Stack& stack);

/// One sentence on the meaning of the quality figure.
std::string qualitySentence(const ReconstructionResult& result);

/// The report of `innergs reconstruct --report`; missing figures are null.
nlohmann::ordered_json reconstructReport(const ReconstructOptions& options,
                                         const std::vector<ScanRecord>& scans,
                                         const ReconstructionResult& result,
                                         const std::vector<std::pair<std::string, double>>& phases);

} // namespace innergs::cli
