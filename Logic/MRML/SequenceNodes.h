#pragma once
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Render.h"

#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkImageData;
class vtkMRMLNode;
class vtkMRMLScene;
class vtkMRMLSequenceBrowserNode;
class vtkMRMLSequenceNode;
class vtkMatrix4x4;
class vtkSlicerInnerGSDynamicRequest;

/// Dynamic scans as Slicer's sequences.
namespace innergs::mrml {

/// The frames of a sequence of scalar volumes in the world (through the parent transform of its proxy node in
/// a browser, if there is one). interval: s from one frame to the next; 0: from the sequence's index. Without
/// `voxels` the frames stay empty. Throws Error, with one sentence, if it is not a dynamic scan.
TimeSeries seriesOf(vtkMRMLSequenceNode* sequence, double interval, bool voxels);

/// When the slices of a frame were acquired: from the request, else from the sequence, else from the BIDS
/// file beside the file that it was read from; empty if none of them says. Throws Error(InvalidArgument |
/// FileNotFound | FileFormat).
SliceTiming sliceTimingOf(vtkSlicerInnerGSDynamicRequest* request, const GridGeometry& grid);

/// The frames' times in s. Throws Error(InvalidArgument) if the index is not a time.
std::vector<double> timesOf(vtkMRMLSequenceNode* sequence, double interval);

/// The browser that a sequence belongs to, or null.
vtkSmartPointer<vtkMRMLSequenceBrowserNode> browserOf(vtkMRMLSequenceNode* sequence);

/// Replaces a sequence's content by one node per time; the index is time in s.
class SequenceWriter {
public:
  explicit SequenceWriter(vtkMRMLSequenceNode* sequence);
  void add(vtkMRMLNode* dataNode, double time); // a copy

private:
  vtkSmartPointer<vtkMRMLSequenceNode> sequence_;
};

/// A new sequence node in the scene, beside another node; an observer may have removed it again.
vtkSmartPointer<vtkMRMLSequenceNode> addSequence(vtkMRMLScene* scene, const std::string& name,
                                                 vtkMRMLNode* beside);
/// Puts the sequence into `like`'s browser if their indices agree, else into one of its own.
vtkSmartPointer<vtkMRMLSequenceBrowserNode> browse(vtkMRMLSequenceNode* sequence, vtkMRMLSequenceNode* like);

/// A dynamic scan's frames, rendered on its own grid: voxels as floats. device: as in Settings. Throws
/// Error(Cancelled | Memory), as DeviceChoice does.
std::vector<vtkSmartPointer<vtkImageData>>
renderFrames(const DynamicField& field, const std::vector<double>& times, const RenderOptions& options = {},
             const std::string& device = "auto", const std::function<void(double)>& report = {});
/// Puts rendered frames into a sequence.
void fillFrames(vtkMRMLSequenceNode* sequence, const DynamicField& field, const std::vector<double>& times,
                const std::vector<vtkSmartPointer<vtkImageData>>& frames);
/// Displacements from one time to each of the others as grid transforms.
void fillMotion(vtkMRMLSequenceNode* sequence, const DynamicField& field, const std::vector<double>& times,
                double from);

} // namespace innergs::mrml
