#pragma once
#include "Core/Image/Volume.h"

#include <optional>
#include <string>
#include <vector>

class vtkMRMLNode;
class vtkMRMLVolumeNode;

namespace innergs::mrml {

/// A mask for estimates, rebuilt only if the mask, its voxels or its place have changed, since every change
/// in a panel asks for an estimate. Main thread.
class OutlineMask {
public:
  /// The mask on its own grid (LPS); null without a mask, for surfaces, which would take Slicer's slow
  /// conversion, and for masks that the job will refuse. segment, `like`, grids: as SegmentationMask's.
  const Mask* of(vtkMRMLNode* node, const std::string& segment, vtkMRMLVolumeNode* like,
                 const std::vector<GridGeometry>& grids);

private:
  std::string key_;
  std::optional<Mask> mask_;
};

} // namespace innergs::mrml
