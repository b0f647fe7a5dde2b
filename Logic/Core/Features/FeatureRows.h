#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Features/FeatureStep.h"

#include <cstdint>
#include <vector>

namespace innergs {

class FeatureRenderer;
struct GaussianField;

/// The linear map from the Gaussians' latents to F at some voxels, stored by rows (voxels) and by columns
/// (Gaussians), so that both F and the gradient of the latents are gathers.
class FeatureRows {
public:
  std::vector<std::int64_t> voxels; // per row

  std::int64_t columns() const { return static_cast<std::int64_t>(columnStart.size()) - 1; }
  bool isEmpty(std::int64_t column) const { return columnStart[column] == columnStart[column + 1]; }
  template <class Each>
  void forRow(std::int64_t row, Each&& each) const { // each(Gaussian, weight)
    for (std::int64_t n = rowStart[row]; n < rowStart[row + 1]; ++n)
      each(rowEntries[n].index, rowEntries[n].weight);
  }
  template <class Each>
  void forColumn(std::int64_t column, Each&& each) const { // each(row, weight)
    for (std::int64_t n = columnStart[column]; n < columnStart[column + 1]; ++n)
      each(columnEntries[n].index, columnEntries[n].weight);
  }

  std::vector<std::int64_t> rowStart, columnStart{0};
  std::vector<FeatureEntry> rowEntries, columnEntries;
};

/// The rows for those of `voxelCount` voxels that the chosen Gaussians reach: all of them or, if there are
/// too many, an even selection.
FeatureRows rowsOf(const FeatureRenderer& renderer, const std::vector<std::uint8_t>& chosen,
                   std::int64_t voxelCount, const GaussianField& field, ThreadPool& pool);

} // namespace innergs
