#pragma once
#include "Core/Image/Volume.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <map>
#include <stop_token>
#include <string>
#include <vector>

class vtkMatrix4x4;
class vtkMRMLSegmentationNode;
class vtkMRMLVolumeNode;
class vtkOrientedImageData;
class vtkSegment;
class vtkSegmentation;

namespace innergs::mrml {

class DetachedTasks;

/// A segmentation as a job's mask. The main thread copies what may change; the worker makes the mask of it,
/// merging labelmaps and making voxels of surfaces.
class SegmentationMask {
public:
  /// Copies the labelmaps, as far as they reach into the `grids` (LPS) that the mask is for, or the surfaces
  /// where there are none. segment: an ID, or "" for all. `like`: gives surfaces their voxels.
  /// Throws Error.
  SegmentationMask(vtkMRMLSegmentationNode* node, const std::string& segment, vtkMRMLVolumeNode* like,
                   const std::vector<GridGeometry>& grids);
  ~SegmentationMask();
  /// Only checks that a segmentation is usable, without looking at voxels. Throws Error.
  static void check(vtkMRMLSegmentationNode* node, const std::string& segment);
  SegmentationMask(const SegmentationMask&) = delete;
  SegmentationMask& operator=(const SegmentationMask&) = delete;

  /// Whether make() has to ask Slicer for the voxels of surfaces.
  bool hasSurfaces() const { return !others_.empty(); }
  /// All segments in one (LPS), on any thread; uses the copies up. Slicer's conversion of surfaces cannot be
  /// stopped. Throws Error, Error(Cancelled).
  Mask make(const std::stop_token& stop, DetachedTasks& unstoppable);

private:
  struct Layer {
    vtkSmartPointer<vtkOrientedImageData> image; // several segments may share one
    std::vector<double> labels;                  // the segments' values, ascending
  };
  void takeLabelmap(vtkOrientedImageData* image, int label, const std::vector<GridGeometry>& grids,
                    double margin);
  void takeOthers(vtkSegment* segment);
  void addLayer(vtkOrientedImageData* image, int label);
  void makeVoxels(const std::stop_token& stop, DetachedTasks& unstoppable);
  /// The lattice to merge on, as Slicer chooses it.
  void chooseLattice(vtkOrientedImageData* lattice);

  std::string name_; // of the node, for sentences
  bool single_;      // one segment: its own lattice
  bool cropped_ = false;
  vtkNew<vtkMatrix4x4> nodeToWorld_;
  std::map<vtkOrientedImageData*, vtkSmartPointer<vtkOrientedImageData>> copies_;
  std::vector<Layer> layers_;
  std::vector<vtkSmartPointer<vtkSegment>> others_; // without a labelmap
  // Slicer's conversion rules, with the node's parameters.
  vtkSmartPointer<vtkSegmentation> converter_;
  vtkNew<vtkSegmentation> merger_;
};

} // namespace innergs::mrml
