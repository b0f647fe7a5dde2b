#include "SequenceNodes.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Motion/FrameRenderer.h"
#include "Core/Motion/MotionField.h"
#include "Geometry.h"
#include "IO/BidsSidecar.h"
#include "IO/FilePath.h"
#include "ImageVoxels.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "vtkSlicerInnerGSDynamicRequest.h"

#include <vtkMRMLGridTransformNode.h>
#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLStorageNode.h>
#include <vtkMRMLVectorVolumeNode.h>
#include <vtkOrientedGridTransform.h>

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>

namespace innergs::mrml {

std::vector<double> timesOf(vtkMRMLSequenceNode* sequence, double interval) {
  std::vector<double> times;
  const int frames = sequence->GetNumberOfDataNodes();
  if (interval != 0) {
    if (!(std::isfinite(interval) && interval > 0))
      throw Error(ErrorCode::InvalidArgument, "The time between frames must be above 0 s.");
    for (int f = 0; f < frames; ++f)
      times.push_back(interval * f);
    return times;
  }
  const std::string unit = sequence->GetIndexUnit(), name = sequence->GetIndexName();
  const bool time = name == "time" || name == "Time" || name.find("(s)") != std::string::npos;
  const double seconds = unit.empty() && time ? 1 : secondsOf(unit);
  if (seconds == 0 || sequence->GetIndexType() != vtkMRMLSequenceNode::NumericIndex)
    throw Error(ErrorCode::InvalidArgument,
                quoted(sequence) + " counts its frames by '" + (unit.empty() ? name : unit) +
                    "', which is no unit of time: give the time from one frame to the next in seconds.");
  for (int f = 0; f < frames; ++f) {
    const auto value = wholeTextNumber(sequence->GetNthIndexValue(f));
    if (!value)
      throw Error(ErrorCode::InvalidArgument, quoted(sequence) + " has the time '" +
                                                  sequence->GetNthIndexValue(f) +
                                                  "', which is no number: correct it.");
    times.push_back(*value * seconds);
  }
  return times;
}

SliceTiming sliceTimingOf(vtkSlicerInnerGSDynamicRequest* request, const GridGeometry& grid) {
  vtkMRMLSequenceNode* sequence = request->GetSeries();
  if (vtkDoubleArray* times = request->GetSliceTimes(); times && times->GetNumberOfValues() > 0)
    return {2, {times->GetPointer(0), times->GetPointer(0) + times->GetNumberOfValues()}};
  if (const std::string file = request->GetSliceTimingFileName(); !file.empty())
    return readSliceTiming(pathOf(file), grid);
  if (const char* text = sequence->GetAttribute("InnerGS.SliceTiming"); text && *text) {
    const char* direction = sequence->GetAttribute("InnerGS.SliceEncodingDirection");
    return sliceTimingFrom(text, direction ? direction : "", 2, grid, quoted(sequence));
  }
  vtkMRMLStorageNode* storage = sequence->GetStorageNode();
  if (const std::string file = storage ? storage->GetFullNameFromFileName() : std::string(); !file.empty())
    if (auto timing = bidsSliceTiming(sidecarOf(pathOf(file)), 2, grid)) return *timing;
  return {};
}

vtkSmartPointer<vtkMRMLSequenceBrowserNode> browserOf(vtkMRMLSequenceNode* sequence) {
  vtkMRMLScene* scene = sequence ? sequence->GetScene() : nullptr;
  std::vector<vtkMRMLNode*> browsers;
  if (scene) scene->GetNodesByClass("vtkMRMLSequenceBrowserNode", browsers);
  for (vtkMRMLNode* node : browsers)
    if (auto* browser = vtkMRMLSequenceBrowserNode::SafeDownCast(node);
        browser->IsSynchronizedSequenceNode(sequence, true))
      return browser;
  return nullptr;
}

TimeSeries seriesOf(vtkMRMLSequenceNode* sequence, double interval, bool voxels) {
  if (!sequence)
    throw Error(ErrorCode::InvalidArgument,
                "There is no dynamic scan: choose a sequence of volumes (load a 4D file as a sequence).");
  TimeSeries series;
  series.name = quoted(sequence);
  const int frames = sequence->GetNumberOfDataNodes();
  if (frames < 2)
    throw Error(ErrorCode::InvalidArgument, series.name +
                                                (frames == 1 ? " has a single frame" : " has no frames") +
                                                "; a dynamic scan needs at least two.");
  for (int f = 0; f < frames; ++f) {
    vtkMRMLNode* node = sequence->GetNthDataNode(f);
    auto* volume = vtkMRMLScalarVolumeNode::SafeDownCast(node);
    if (!volume || vtkMRMLVectorVolumeNode::SafeDownCast(node) ||
        vtkMRMLLabelMapVolumeNode::SafeDownCast(node))
      throw Error(ErrorCode::UnsupportedImage, series.name + " holds something other than scalar volumes: "
                                                             "choose a sequence of scans.");
    const std::string what = "Frame " + std::to_string(f) + " of " + series.name;
    const GridGeometry grid = gridOf(volume);
    if (f == 0)
      series.geometry = grid;
    else if (!sameGrid(series.geometry, grid))
      throw Error(ErrorCode::Geometry,
                  what + " lies on another grid than the first: resample all frames to one first.");
    vtk::checkVoxels(volume->GetImageData(), what);
    if (voxels) series.frames.push_back(vtk::voxelsOf(volume->GetImageData(), {{0, 0, 0}, grid.size}, what));
  }
  if (auto browser = browserOf(sequence))
    if (auto* proxy = vtkMRMLVolumeNode::SafeDownCast(browser->GetProxyNode(sequence));
        proxy && proxy->GetParentTransformNode() && proxy->GetImageData() &&
        sameGrid(series.geometry,
                 [&] { // its own grid, without the parent
                   vtkNew<vtkMatrix4x4> ijkToRAS;
                   proxy->GetIJKToRASMatrix(ijkToRAS);
                   return vtk::gridOf(proxy->GetImageData(), ijkToRAS, quoted(proxy));
                 }()))
      series.geometry = gridOf(proxy);
  series.times = timesOf(sequence, interval);
  for (std::size_t f = 1; f < series.times.size(); ++f)
    if (!(series.times[f] > series.times[f - 1]))
      throw Error(ErrorCode::InvalidArgument,
                  series.name + " has times that do not increase: give every frame a time of its own.");
  if (voxels) checkTimeSeries(series);
  return series;
}

SequenceWriter::SequenceWriter(vtkMRMLSequenceNode* sequence) : sequence_(sequence) {
  sequence_->RemoveAllDataNodes();
  sequence_->SetIndexName("time");
  sequence_->SetIndexUnit("s");
  sequence_->SetIndexType(vtkMRMLSequenceNode::NumericIndex);
  sequence_->SetNumericIndexValueTolerance(1e-6);
}

void SequenceWriter::add(vtkMRMLNode* dataNode, double time) {
  sequence_->SetDataNodeAtValue(dataNode, exactText(time));
}

vtkSmartPointer<vtkMRMLSequenceNode> addSequence(vtkMRMLScene* scene, const std::string& name,
                                                 vtkMRMLNode* beside) {
  if (!scene)
    throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a sequence to: set one.");
  vtkSmartPointer<vtkMRMLSequenceNode> made =
      vtkMRMLSequenceNode::SafeDownCast(addNode(scene, "vtkMRMLSequenceNode", name));
  placeBeside(made, beside);
  return made;
}

vtkSmartPointer<vtkMRMLSequenceBrowserNode> browse(vtkMRMLSequenceNode* sequence, vtkMRMLSequenceNode* like) {
  vtkMRMLScene* scene = sequence->GetScene();
  if (!scene) return nullptr;
  if (auto browser = browserOf(sequence)) return browser;
  const auto agrees = [&] {
    const int count = sequence->GetNumberOfDataNodes();
    if (!like || like->GetNumberOfDataNodes() != count) return false;
    for (int f = 0; f < count; ++f) {
      const auto a = wholeTextNumber(like->GetNthIndexValue(f)),
                 b = wholeTextNumber(sequence->GetNthIndexValue(f));
      if (!a || !b || std::abs(*a - *b) > 1e-6) return false;
    }
    return true;
  };
  if (auto browser = agrees() ? browserOf(like) : nullptr) {
    browser->AddSynchronizedSequenceNodeID(sequence->GetID());
    return browser;
  }
  const std::string name = nameOf(sequence, "Sequence") + " browser";
  vtkSmartPointer<vtkMRMLSequenceBrowserNode> browser =
      vtkMRMLSequenceBrowserNode::SafeDownCast(addNode(scene, "vtkMRMLSequenceBrowserNode", name));
  if (browser && browser->GetScene()) browser->SetAndObserveMasterSequenceNodeID(sequence->GetID());
  return browser;
}

std::vector<vtkSmartPointer<vtkImageData>>
renderFrames(const DynamicField& field, const std::vector<double>& times, const RenderOptions& options,
             const std::string& device, const std::function<void(double)>& report) {
  const GridGeometry& grid = field.canonical.region();
  const std::int64_t available = availableMemory(),
                     bytes = 4 * grid.voxelCount() * static_cast<std::int64_t>(times.size());
  if (available > 0 && bytes > available - (std::int64_t{1} << 28))
    throw Error(ErrorCode::Memory, "That many frames do not fit into memory: choose a lower rate.");
  FrameRenderer renderer(field, grid, options, device);
  std::vector<vtkSmartPointer<vtkImageData>> frames;
  for (const double time : times) {
    const std::vector<float> voxels = renderer.at(time);
    auto image = vtkSmartPointer<vtkImageData>::New();
    std::copy(voxels.begin(), voxels.end(), vtk::allocateFloats(image, grid, false));
    frames.push_back(image);
    if (report) report(static_cast<double>(frames.size()) / static_cast<double>(times.size()));
  }
  return frames;
}

void fillFrames(vtkMRMLSequenceNode* sequence, const DynamicField& field, const std::vector<double>& times,
                const std::vector<vtkSmartPointer<vtkImageData>>& frames) {
  vtkNew<vtkMatrix4x4> ijkToRAS;
  vtk::toMatrix(field.canonical.region(), ijkToRAS);
  SequenceWriter writer(sequence);
  for (std::size_t f = 0; f < times.size(); ++f) {
    vtkNew<vtkMRMLScalarVolumeNode> volume;
    volume->SetIJKToRASMatrix(ijkToRAS);
    volume->SetAndObserveImageData(frames[f]);
    writer.add(volume, times[f]);
  }
}

void fillMotion(vtkMRMLSequenceNode* sequence, const DynamicField& field, const std::vector<double>& times,
                double from) {
  const GridGeometry& grid = field.canonical.region();
  if (std::isnan(from)) from = middleTime(field);
  std::vector<std::vector<float>> fields; // before anything changes
  for (const double time : times)
    fields.push_back(motionField(field, from, time, grid));
  SequenceWriter writer(sequence);
  for (std::size_t f = 0; f < times.size(); ++f) {
    vtkNew<vtkImageData> image;
    float* out = vtk::allocateFloats(image, grid, false, 3);
    for (std::size_t n = 0; n < fields[f].size(); n += 3) { // LPS to RAS
      out[n] = -fields[f][n];
      out[n + 1] = -fields[f][n + 1];
      out[n + 2] = fields[f][n + 2];
    }
    vtkNew<vtkMatrix4x4> ijkToRAS, direction;
    vtk::toMatrix(grid, ijkToRAS);
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i)
        direction->SetElement(i, a, ijkToRAS->GetElement(i, a) / grid.spacing[a]);
    image->SetOrigin(ijkToRAS->GetElement(0, 3), ijkToRAS->GetElement(1, 3), ijkToRAS->GetElement(2, 3));
    image->SetSpacing(grid.spacing.data());
    vtkNew<vtkOrientedGridTransform> displacement;
    displacement->SetDisplacementGridData(image);
    displacement->SetGridDirectionMatrix(direction);
    displacement->SetInterpolationModeToLinear();
    vtkNew<vtkMRMLGridTransformNode> node;
    node->SetAndObserveTransformFromParent(displacement);
    writer.add(node, times[f]);
  }
}

} // namespace innergs::mrml
