#pragma once
#include "Core/Image/Volume.h"

#include <optional>
#include <string>
#include <vector>

class vtkMRMLNode;
class vtkMRMLVolumeNode;

namespace innergs::mrml {

/// One mask of estimates: rebuilt only when the mask, its voxels or its place have changed, since every
/// choice in a panel is estimated. Main thread.
class OutlineMask {
public:
  /// On its own lattice (LPS); null without a mask, for surfaces, which only Slicer's slow conversion could
  /// count, and for what the job will refuse. segment, `like`, grids: as SegmentationMask's.
  const Mask* of(vtkMRMLNode* node, const std::string& segment, vtkMRMLVolumeNode* like,
                 const std::vector<GridGeometry>& grids);

private:
  std::string key_;
  std::optional<Mask> mask_;
};

} // namespace innergs::mrml
