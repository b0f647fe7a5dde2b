#include "OutlineMask.h"

#include "Core/Base/Error.h"
#include "DetachedTasks.h"
#include "ImageVoxels.h"
#include "NodeGeometry.h"
#include "SegmentationMask.h"

#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>

#include <sstream>

namespace innergs::mrml {
namespace {

void add(std::ostream& key, vtkMatrix4x4* matrix) {
  for (int i = 0; i < 16; ++i)
    key << ' ' << matrix->GetElement(i / 4, i % 4);
}

void add(std::ostream& key, const GridGeometry& grid) {
  for (int a = 0; a < 3; ++a) {
    key << ' ' << grid.size[a] << ' ' << grid.spacing[a] << ' ' << grid.origin[a];
    for (int b = 0; b < 3; ++b)
      key << ' ' << grid.direction[a][b];
  }
}

std::string keyOf(vtkMRMLSegmentationNode* node, const std::string& segment,
                  const std::vector<GridGeometry>& grids) {
  std::ostringstream key;
  key.imbue(std::locale::classic());
  key.precision(17);
  vtkSegmentation* segments = node->GetSegmentation();
  key << static_cast<const void*>(segments) << ' ' << segments->GetMTime() << ' ' << segment;
  for (int n = 0; n < segments->GetNumberOfSegments(); ++n) {
    vtkDataObject* image = segments->GetNthSegment(n)->GetRepresentation(
        vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName());
    key << ' ' << static_cast<const void*>(image) << ' ' << (image ? image->GetMTime() : 0);
  }
  vtkNew<vtkMatrix4x4> matrix;
  toWorld(node, matrix);
  add(key, matrix);
  for (const GridGeometry& grid : grids)
    add(key, grid);
  return key.str();
}

std::string keyOf(vtkMRMLVolumeNode* node) {
  std::ostringstream key;
  key.imbue(std::locale::classic());
  key.precision(17);
  vtkImageData* image = node->GetImageData();
  key << static_cast<const void*>(image) << ' ' << image->GetMTime();
  vtkNew<vtkMatrix4x4> matrix;
  ijkToWorld(node, matrix);
  add(key, matrix);
  return key.str();
}

} // namespace

const Mask* OutlineMask::of(vtkMRMLNode* node, const std::string& segment, vtkMRMLVolumeNode* like,
                            const std::vector<GridGeometry>& grids) {
  auto* segmentation = vtkMRMLSegmentationNode::SafeDownCast(node);
  auto* volume = vtkMRMLVolumeNode::SafeDownCast(node);
  if (!segmentation && !(volume && volume->GetImageData())) return nullptr;
  try {
    std::string key = segmentation ? keyOf(segmentation, segment, grids) : keyOf(volume);
    if (key != key_) {
      mask_.reset();
      key_ = std::move(key); // also of one that cannot be made
      if (volume) {
        const GridGeometry grid = gridOf(volume);
        mask_ = Mask{grid, vtk::maskOf(volume->GetImageData(), "The mask")};
      } else if (SegmentationMask copy(segmentation, segment, like, grids); !copy.hasSurfaces()) {
        DetachedTasks none;
        mask_ = copy.make({}, none);
      }
    }
  } catch (const Error&) { // the job will report it
    mask_.reset();
  }
  return mask_ ? &*mask_ : nullptr;
}

} // namespace innergs::mrml
