#include "LogicInternals.h"
#include "Queries.h"
#include "SegmentLearning.h"
#include "vtkInnerGSSegment.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLSegmentationNode.h>

#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

// The logic's segments by what they are called.

namespace mrml = innergs::mrml;

static_assert(static_cast<int>(innergs::AnswerKind::Found) == vtkInnerGSSegment::Found &&
              static_cast<int>(innergs::AnswerKind::Similar) == vtkInnerGSSegment::Similar);

vtkSlicerInnerGSJob*
vtkSlicerInnerGSLogic::Internals::startLearning(const std::function<std::shared_ptr<mrml::Task>()>& prepare) {
  const bool started = this->guard([&] {
    std::shared_ptr<mrml::Task> task = prepare();
    task->job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    task->job->Learning = true;
    const vtkSmartPointer<vtkSlicerInnerGSJob> job = task->job;
    this->queue.submit(std::move(task));
    this->lastJob = job;
  });
  return started ? this->lastJob.Get() : nullptr;
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels,
                                                          bool sparse) {
  return this->Work->startLearning(
      [&] { return mrml::prepareLearning(model, labels, sparse, this->GetMRMLScene()); });
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearningFromFeatures(vtkMRMLInnerGSModelNode* model,
                                                                      vtkMRMLVolumeNode* features,
                                                                      const std::string& textsFile) {
  return this->Work->startLearning(
      [&] { return mrml::prepareFeatureLearning(model, features, textsFile, this->GetMRMLScene()); });
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearningFromNetwork(vtkMRMLInnerGSModelNode* model,
                                                                     const std::string& networkFile,
                                                                     vtkStringArray* names,
                                                                     const std::string& textsFile, double low,
                                                                     double high, double spacing) {
  return this->Work->startLearning([&] {
    mrml::NetworkTeacher network{networkFile, {}, textsFile, {low, high}, spacing};
    for (vtkIdType n = 0; names && n < names->GetNumberOfValues(); ++n)
      network.names.push_back(names->GetValue(n));
    return mrml::prepareNetworkLearning(model, network, this->GetMRMLScene());
  });
}

bool vtkSlicerInnerGSLogic::LearnSegments(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse) {
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = this->StartLearning(model, labels, sparse);
  if (!job) return false;
  this->WaitForJob(job);
  return job->State == vtkSlicerInnerGSJob::Finished;
}

std::function<innergs::NamedLabels(const std::stop_token&)>
vtkSlicerInnerGSLogic::LabelsLater(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels) {
  std::function<innergs::NamedLabels(const std::stop_token&)> later;
  this->Work->guard([&] { later = mrml::labelsLater(model, labels, this->GetMRMLScene()); });
  return later;
}

int vtkSlicerInnerGSLogic::FindByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                      vtkTable* candidates) {
  int kind = -1;
  if (candidates) candidates->Initialize();
  this->Work->guard([&] {
    const innergs::SegmentAnswer answer = this->Work->segments.ask(model, text, 0);
    const innergs::SegmentFinder& finder = this->Work->segments.finder(model);
    kind = static_cast<int>(answer.kind);
    if (!candidates) return;
    vtkNew<vtkStringArray> names;
    vtkNew<vtkDoubleArray> scores;
    vtkNew<vtkIntArray> leading;
    names->SetName("Name");
    scores->SetName("Score");
    leading->SetName("Leading");
    for (std::size_t n = 0; n < answer.candidates.size(); ++n) {
      names->InsertNextValue(finder.nameOf(answer.candidates[n]));
      scores->InsertNextValue(answer.candidates[n].score);
      leading->InsertNextValue(n < answer.leading);
    }
    for (vtkAbstractArray* column :
         {static_cast<vtkAbstractArray*>(names), static_cast<vtkAbstractArray*>(scores),
          static_cast<vtkAbstractArray*>(leading)})
      candidates->AddColumn(column);
  });
  return kind;
}

std::string vtkSlicerInnerGSLogic::GetLastAnswer() {
  return this->Work->segments.answer;
}

vtkMRMLSegmentationNode*
vtkSlicerInnerGSLogic::SegmentByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                     vtkMRMLSegmentationNode* output, double threshold, bool largestOnly,
                                     double minimumSize, double smoothing, double spacing) {
  vtkSmartPointer<vtkMRMLSegmentationNode> made;
  this->Work->guard([&] {
    made = mrml::addSegments(
        this->GetMRMLScene(), model,
        this->Work->segments.made(model, text, spacing, {threshold, smoothing, largestOnly, minimumSize}),
        output);
  });
  return made && made->GetScene() ? made.Get() : nullptr;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ScoreByText(vtkMRMLInnerGSModelNode* model,
                                                            const std::string& text,
                                                            vtkMRMLScalarVolumeNode* output, double spacing) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made =
        mrml::addScore(this->GetMRMLScene(), model, this->Work->segments.made(model, text, spacing), output);
  });
  return made && made->GetScene() ? made.Get() : nullptr;
}

vtkMRMLSegmentationNode* vtkSlicerInnerGSLogic::AddSegments(vtkMRMLInnerGSModelNode* model,
                                                            const innergs::MadeSegments& segments,
                                                            vtkMRMLSegmentationNode* output) {
  vtkSmartPointer<vtkMRMLSegmentationNode> made;
  this->Work->guard([&] {
    mrml::modelOf(model);
    made = mrml::addSegments(this->GetMRMLScene(), model, segments, output);
  });
  return made && made->GetScene() ? made.Get() : nullptr;
}
