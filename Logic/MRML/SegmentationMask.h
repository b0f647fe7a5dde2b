#pragma once
#include "Core/Features/Labelmap.h"
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

/// A segmentation as a job's mask, or as labels to learn from. The main thread copies what may change; the
/// worker makes the mask from it, merging labelmaps and converting surfaces to voxels.
class SegmentationMask {
public:
  /// Copies the labelmaps, as far as they reach into the `grids` (LPS) that the mask is for, or the surfaces
  /// of segments without one. segment: an ID, or "" for all. `like`: gives surfaces their voxels. role: what
  /// messages call it. Throws Error.
  SegmentationMask(vtkMRMLSegmentationNode* node, const std::string& segment, vtkMRMLVolumeNode* like,
                   const std::vector<GridGeometry>& grids, const std::string& role = "mask");
  ~SegmentationMask();
  /// Only checks that a segmentation is usable, without looking at voxels. Throws Error.
  static void check(vtkMRMLSegmentationNode* node, const std::string& segment,
                    const std::string& role = "mask");
  SegmentationMask(const SegmentationMask&) = delete;
  SegmentationMask& operator=(const SegmentationMask&) = delete;

  /// Whether make() has to ask Slicer for the voxels of surfaces.
  bool hasSurfaces() const { return !others_.empty(); }
  /// All segments as one mask (LPS), on any thread; uses up the copies. Slicer's conversion of surfaces
  /// cannot be stopped. Throws Error, Error(Cancelled).
  Mask make(const std::stop_token& stop, DetachedTasks& unstoppable);
  /// The same with the segments kept apart: the n-th of names(), from 0, has the label n + 1; where several
  /// overlap, the last one wins.
  Labelmap makeLabels(const std::stop_token& stop, DetachedTasks& unstoppable);
  const std::vector<std::string>& names() const { return names_; }

private:
  struct Layer {
    vtkSmartPointer<vtkOrientedImageData> image; // several segments may share one
    std::map<double, std::uint16_t> numbers;     // of the segments, from 1, by their values
  };
  void takeLabelmap(vtkOrientedImageData* image, int label, std::uint16_t number,
                    const std::vector<GridGeometry>& grids, double margin);
  void takeOthers(vtkSegment* segment, std::uint16_t number);
  void addLayer(vtkOrientedImageData* image, int label, std::uint16_t number);
  template <class Label>
  GridGeometry mergeAll(std::vector<Label>& voxels, const std::stop_token& stop, DetachedTasks& unstoppable);
  void makeVoxels(const std::stop_token& stop, DetachedTasks& unstoppable);
  /// The grid to merge on, as Slicer chooses it.
  void chooseGrid(vtkOrientedImageData* grid);

  std::string name_;               // "The mask 'Organs'", for sentences
  std::vector<std::string> names_; // of the segments
  bool single_;                    // one segment: its own grid
  bool cropped_ = false;
  vtkNew<vtkMatrix4x4> nodeToWorld_;
  std::map<vtkOrientedImageData*, vtkSmartPointer<vtkOrientedImageData>> copies_;
  std::vector<Layer> layers_;
  struct Other {
    vtkSmartPointer<vtkSegment> segment;
    std::uint16_t number;
  };
  std::vector<Other> others_; // without a labelmap
  // Slicer's conversion rules, with the node's parameters.
  vtkSmartPointer<vtkSegmentation> converter_;
  vtkNew<vtkSegmentation> merger_;
};

} // namespace innergs::mrml
