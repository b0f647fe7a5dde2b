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

/// Moving scans as Slicer's sequences.
namespace innergs::mrml {

/// The frames of a sequence of scalar volumes in the world (through the parent transform of its proxy node in
/// a browser, if there is one). interval: s from one frame to the next, 0 as the sequence's index says.
/// Without `voxels` the frames stay empty. Throws Error for what is no moving scan, with one sentence.
TimeSeries seriesOf(vtkMRMLSequenceNode* sequence, double interval, bool voxels);

/// When the slices of its frames were acquired, as a request says, else the sequence, else the BIDS file
/// beside the one that it was read from; empty: nothing does. Throws Error(InvalidArgument | FileNotFound |
/// FileFormat).
SliceTiming sliceTimingOf(vtkSlicerInnerGSDynamicRequest* request, const GridGeometry& lattice);

/// The frames' times in s. Throws Error(InvalidArgument) where the index is no time.
std::vector<double> timesOf(vtkMRMLSequenceNode* sequence, double interval);

/// The browser in which a sequence is, or null.
vtkSmartPointer<vtkMRMLSequenceBrowserNode> browserOf(vtkMRMLSequenceNode* sequence);

/// Replaces what a sequence holds by one node per time; the index is time in s.
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
/// The sequence in `like`'s browser where the indices agree, else in one of its own.
vtkSmartPointer<vtkMRMLSequenceBrowserNode> browse(vtkMRMLSequenceNode* sequence, vtkMRMLSequenceNode* like);

/// A moving scan's frames, rendered on its own lattice: voxels as floats. device: as in Settings. Throws
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
