#pragma once
#include "Core/Settings/SettingsTable.h"
#include "Evaluation/JudgedSeries.h"
#include "IO/RecoveredFit.h"

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

class vtkDoubleArray;
class vtkImageData;
class vtkMRMLInnerGSModelNode;
class vtkMRMLScene;
class vtkMRMLSequenceBrowserNode;
class vtkMRMLSequenceNode;
class vtkMRMLTableNode;
class vtkSlicerInnerGSDynamicRequest;

namespace innergs::mrml {

/// Nodes made from a dynamic scan; null for those that an observer removed during creation.
struct DynamicOutputs {
  vtkSmartPointer<vtkMRMLInnerGSModelNode> model;
  vtkSmartPointer<vtkMRMLSequenceNode> frames;
  vtkSmartPointer<vtkMRMLSequenceBrowserNode> browser;
  vtkSmartPointer<vtkMRMLTableNode> table; // null unless the quality was judged
  std::vector<std::string> warnings;
};

/// The reconstruction of a dynamic scan: made on the main thread, which copies the voxels, run on any, and
/// turned into nodes on the main thread again.
class DynamicWork {
public:
  /// Throws Error if something is wrong with the request.
  explicit DynamicWork(vtkSlicerInnerGSDynamicRequest* request);

  using PreviewCallback = std::function<void(std::shared_ptr<const DynamicField>)>;
  /// False when it was stopped before there was a result. Throws Error.
  bool run(const std::stop_token& stop, const ProgressCallback& tell, const PreviewCallback& show);

  /// The file that it continues; empty: none.
  const std::filesystem::path& resumeFile() const { return resumeFile_; }
  bool keepsWhenCancelled() const { return keepWhenCancelled_; }
  /// After run(): writes the current or final state of the fit to the folder and completes `about`; leaves it
  /// without a file if there is nothing to continue. Throws Error.
  void keep(RecoveredFit& about, const std::filesystem::path& folder) const;
  /// What is known of it before the start.
  RecoveredFit about() const;

  /// Throws Error.
  DynamicOutputs makeNodes(vtkMRMLScene* scene);
  double trainingPsnr() const { return outcome_.result.trainingPsnr; }
  int judging() const { return static_cast<int>(outcome_.judging); }
  std::string settingsText() const { return dynamicSettingsText(outcome_.result.settings); }

private:
  TimeSeries series_;
  Settings settings_;
  bool judge_, keepWhenCancelled_;
  double interval_;
  std::filesystem::path resumeFile_;
  std::vector<double> times_; // of the frames to make
  std::string name_;
  vtkWeakPointer<vtkMRMLSequenceNode> sequence_;
  JudgedSeriesResult outcome_;
  std::vector<vtkSmartPointer<vtkImageData>> frames_;
};

/// The times to make frames at, s: `times`, or `rate` per second, or the series' own. Throws
/// Error(InvalidArgument) for times outside the series' and times that do not increase.
std::vector<double> framesWanted(vtkDoubleArray* times, double rate, const std::vector<double>& own);

} // namespace innergs::mrml
