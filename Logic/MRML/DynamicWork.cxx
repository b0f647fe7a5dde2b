#include "DynamicWork.h"

#include "Core/Base/Error.h"
#include "Core/Job/MemoryEstimate.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "QualityTable.h"
#include "SequenceNodes.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkSlicerInnerGSDynamicRequest.h"

#include <vtkMRMLScene.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkTable.h>

namespace innergs::mrml {

std::vector<double> framesWanted(vtkDoubleArray* times, double rate, const std::vector<double>& own) {
  if (!times || times->GetNumberOfValues() == 0) return timesAtRate(rate, own);
  return checkedTimes({times->GetPointer(0), times->GetPointer(0) + times->GetNumberOfValues()}, own);
}

DynamicWork::DynamicWork(vtkSlicerInnerGSDynamicRequest* request) {
  if (!request) throw Error(ErrorCode::InvalidArgument, "There is no request: give one.");
  series_ = seriesOf(request->GetSeries(), request->GetInterval(), true);
  series_.sliceTiming = sliceTimingOf(request, series_.geometry);
  if (!series_.sliceTiming.empty()) checkTimeSeries(series_); // its slice times too
  sequence_ = request->GetSeries();
  name_ = nameOf(sequence_, "Sequence");
  times_ = framesWanted(request->GetTimes(), request->GetRate(), series_.times);
  judge_ = request->GetEvaluateQuality();
  keepWhenCancelled_ = request->GetKeepWhenCancelled();
  interval_ = request->GetInterval();
  if (const std::string file = request->GetResumeFileName(); !file.empty()) {
    resumeFile_ = pathOf(file);
    checkInputFile(resumeFile_);
  }
  settings_ = request->GetSettings();
  checkSettings(settings_);
  if (const std::string refusal = memoryRefusal(estimateMemory(series_, settings_), availableMemory());
      !refusal.empty())
    throw Error(ErrorCode::Memory, refusal);
}

RecoveredFit DynamicWork::about() const {
  RecoveredFit about;
  about.inputs = name_;
  about.settings = settings_;
  about.dynamic = true;
  about.interval = interval_;
  return about;
}

void DynamicWork::keep(RecoveredFit& about, const std::filesystem::path& folder) const {
  writeStoppedFit(outcome_.result, about, folder);
}

bool DynamicWork::run(const std::stop_token& stop, const ProgressCallback& tell,
                      const PreviewCallback& show) {
  constexpr double fitted = 0.95; // share of the work; the rest renders the frames
  Progress last;
  JudgedSeries job(std::move(series_), settings_, judge_);
  if (!resumeFile_.empty()) job.resume(readStoppedFit(resumeFile_));
  job.onPreview(show);
  job.onProgress([&](Progress progress) {
    progress.fraction *= fitted;
    last = progress;
    if (tell) tell(progress);
  });
  outcome_ = job.run(stop);
  if (outcome_.result.cancelled || !outcome_.result.field) return false;
  const bool judged = last.phase == Phase::Judging; // a stop has ended only the judging
  last.phase = judged ? Phase::Judging : Phase::Rendering;
  last.note.clear(); // already reported
  RenderOptions options;
  options.threads = settings_.threads;
  if (!judged) options.stop = stop;
  frames_ = renderFrames(*outcome_.result.field, times_, options, settings_.device, [&](double share) {
    last.fraction = fitted + (1 - fitted) * share;
    last.remaining = 0;
    if (tell) tell(last);
  });
  return true;
}

DynamicOutputs DynamicWork::makeNodes(vtkMRMLScene* scene) {
  const DynamicField& field = *outcome_.result.field;
  const vtkSmartPointer<vtkMRMLSequenceNode> input =
      sequence_ && sequence_->GetScene() == scene ? sequence_.Get() : nullptr;
  const auto there = [&](vtkMRMLNode* node) { return node && node->GetScene() == scene; };
  const ModelNotes notes = notesOf(outcome_.result, name_);
  const auto provenance = [&](vtkMRMLNode* node) {
    MRMLNodeModifyBlocker blocker(node);
    for (const auto& [name, text] : notes)
      node->SetAttribute(("InnerGS." + name).c_str(), text.c_str());
  };
  DynamicOutputs made;
  for (const std::string& sentence : {outcome_.note, outcome_.result.choice})
    if (!sentence.empty()) made.warnings.push_back(sentence);
  for (const std::string& note : outcome_.result.notes)
    made.warnings.push_back(note);
  made.model = vtkMRMLInnerGSModelNode::SafeDownCast(
      addNode(scene, "vtkMRMLInnerGSModelNode", name_ + " InnerGS model"));
  if (there(made.model)) {
    provenance(made.model);
    vtkNew<vtkInnerGSDynamicModel> model;
    model->SetField(outcome_.result.field);
    made.model->SetTime(field.times.front());
    made.model->SetDynamicModel(model);
    placeBeside(made.model, input);
  }
  made.frames = addSequence(scene, name_ + " InnerGS", input);
  if (there(made.frames)) {
    provenance(made.frames);
    fillFrames(made.frames, field, times_, frames_);
    if (there(made.model)) made.frames->SetNodeReferenceID("InnerGSModel", made.model->GetID());
    if (there(made.frames)) made.browser = browse(made.frames, there(input) ? input.Get() : nullptr);
  }
  frames_.clear();
  if (outcome_.quality) {
    made.table =
        vtkMRMLTableNode::SafeDownCast(addNode(scene, "vtkMRMLTableNode", name_ + " InnerGS quality"));
    if (there(made.table)) {
      provenance(made.table);
      setQuality(made.table, makeQualityTable(*outcome_.quality), *outcome_.quality);
      if (there(made.model)) made.table->SetNodeReferenceID("InnerGSModel", made.model->GetID());
      placeBeside(made.table, input);
    }
  }
  if (!there(made.model)) made.model = nullptr;
  if (!there(made.frames)) made.frames = nullptr;
  if (!there(made.browser)) made.browser = nullptr;
  if (!there(made.table)) made.table = nullptr;
  return made;
}

} // namespace innergs::mrml
