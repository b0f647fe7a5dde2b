#include "vtkInnerGSSegment.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "Text/SegmentFinder.h"
#include "vtkInnerGSModel.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"

#include <algorithm>
#include <limits>

vtkStandardNewMacro(vtkInnerGSSegment);

namespace {

struct MadeSegment {
  innergs::SegmentTerms terms;
  double volume = 0; // mm³
};

template <class T>
const T* at(const std::vector<T>& list, int index) {
  return index >= 0 && index < static_cast<int>(list.size()) ? &list[static_cast<std::size_t>(index)]
                                                             : nullptr;
}

} // namespace

struct vtkInnerGSSegment::Internals {
  std::vector<std::string> queries;
  innergs::vtk::ReferenceGrid reference;
  vtkNew<vtkMatrix4x4> outputToRAS;
  vtkNew<vtkInnerGSModel> model; // that the finder is for
  std::optional<innergs::SegmentFinder> finder;
  std::vector<innergs::SegmentAnswer> answers; // per query
  std::vector<std::vector<std::string>> names; // of their candidates
  std::vector<MadeSegment> segments;

  const innergs::SegmentAnswer* answer(int query) const { return at(answers, query); }
};

vtkInnerGSSegment::vtkInnerGSSegment() : Work(std::make_unique<Internals>()) {
  this->SetNumberOfOutputPorts(2);
}
vtkInnerGSSegment::~vtkInnerGSSegment() = default;

void vtkInnerGSSegment::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  for (const std::string& query : this->Work->queries)
    os << indent << "Query: " << query << "\n";
  os << indent << "Threshold: " << this->Threshold << "\n";
  os << indent << "Smoothing: " << this->Smoothing << "\n";
  os << indent << "LargestOnly: " << this->LargestOnly << "\n";
  os << indent << "MinimumSize: " << this->MinimumSize << "\n";
  os << indent << "MakeScore: " << this->MakeScore << "\n";
  os << indent << "OutputSpacing: " << this->OutputSpacing[0] << " " << this->OutputSpacing[1] << " "
     << this->OutputSpacing[2] << "\n";
  os << indent << "ReferenceGrid: " << (this->Work->reference.given() ? "given" : "none") << "\n";
}

void vtkInnerGSSegment::AddQuery(const std::string& text) {
  this->Work->queries.push_back(text);
  this->Modified();
}

void vtkInnerGSSegment::RemoveAllQueries() {
  if (this->Work->queries.empty()) return;
  this->Work->queries.clear();
  this->Modified();
}

void vtkInnerGSSegment::SetQuery(const std::string& text) {
  if (this->Work->queries == std::vector<std::string>{text}) return;
  this->Work->queries = {text};
  this->Modified();
}

int vtkInnerGSSegment::GetNumberOfQueries() {
  return static_cast<int>(this->Work->queries.size());
}

std::string vtkInnerGSSegment::GetQuery(int index) {
  const std::string* query = at(this->Work->queries, index);
  return query ? *query : "";
}

void vtkInnerGSSegment::SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ,
                                         int dimensionK) {
  const int dimensions[3] = {dimensionI, dimensionJ, dimensionK}, first[3] = {0, 0, 0};
  if (this->Work->reference.set(ijkToRAS, dimensions, first)) this->Modified();
}

void vtkInnerGSSegment::SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  if (this->Work->reference.set(image, ijkToRAS)) this->Modified();
}

vtkImageData* vtkInnerGSSegment::GetOutput() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(0));
}

vtkImageData* vtkInnerGSSegment::GetScore() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}

vtkMatrix4x4* vtkInnerGSSegment::GetOutputIJKToRASMatrix() {
  return this->Work->outputToRAS;
}

int vtkInnerGSSegment::GetAnswer(int query) {
  const innergs::SegmentAnswer* answer = this->Work->answer(query);
  return answer ? static_cast<int>(answer->kind) : static_cast<int>(NoMatch);
}

std::string vtkInnerGSSegment::GetAnswerText(int query) {
  const innergs::SegmentAnswer* answer = this->Work->answer(query);
  return answer ? answer->sentence : "";
}

int vtkInnerGSSegment::GetNumberOfCandidates(int query) {
  const innergs::SegmentAnswer* answer = this->Work->answer(query);
  return answer ? static_cast<int>(answer->candidates.size()) : 0;
}

std::string vtkInnerGSSegment::GetCandidateName(int query, int candidate) {
  const auto* names = at(this->Work->names, query);
  const std::string* name = names ? at(*names, candidate) : nullptr;
  return name ? *name : "";
}

double vtkInnerGSSegment::GetCandidateScore(int query, int candidate) {
  const innergs::SegmentAnswer* answer = this->Work->answer(query);
  const innergs::SegmentCandidate* found = answer ? at(answer->candidates, candidate) : nullptr;
  return found ? found->score : 0;
}

int vtkInnerGSSegment::GetNumberOfLeadingCandidates(int query) {
  const innergs::SegmentAnswer* answer = this->Work->answer(query);
  return answer ? static_cast<int>(answer->leading) : 0;
}

int vtkInnerGSSegment::GetNumberOfSegments() {
  return static_cast<int>(this->Work->segments.size());
}

std::string vtkInnerGSSegment::GetSegmentName(int index) {
  const MadeSegment* segment = at(this->Work->segments, index);
  return segment ? segment->terms.name : "";
}

std::string vtkInnerGSSegment::GetSegmentCode(int index) {
  const MadeSegment* segment = at(this->Work->segments, index);
  return segment ? segment->terms.code : "";
}

std::string vtkInnerGSSegment::GetSegmentMeaning(int index) {
  const MadeSegment* segment = at(this->Work->segments, index);
  return segment ? segment->terms.meaning : "";
}

std::string vtkInnerGSSegment::GetSegmentSide(int index) {
  const MadeSegment* segment = at(this->Work->segments, index);
  const innergs::Side side = segment ? segment->terms.side : innergs::Side::None;
  return side == innergs::Side::Left ? "left" : side == innergs::Side::Right ? "right" : "";
}

void vtkInnerGSSegment::GetSegmentColor(int index, double color[3]) {
  const MadeSegment* segment = at(this->Work->segments, index);
  const innergs::SegmentTerms terms = segment ? segment->terms : innergs::SegmentTerms();
  std::copy(terms.color.begin(), terms.color.end(), color);
}

double vtkInnerGSSegment::GetSegmentVolume(int index) {
  const MadeSegment* segment = at(this->Work->segments, index);
  return segment ? segment->volume : 0;
}

void vtkInnerGSSegment::RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  const auto field = this->RequireModel(inputs)->GetField();
  vtkInformation* output = outputs->GetInformationObject(0);
  innergs::vtk::announceImage(
      output, innergs::vtk::outputGrid(field->region(), this->Work->reference, this->OutputSpacing),
      this->GeometryInImage);
  vtkDataObject::SetPointDataActiveScalarInfo(output, VTK_UNSIGNED_CHAR, 1);
  if (this->MakeScore)
    innergs::vtk::announceImage(
        outputs->GetInformationObject(1),
        innergs::vtk::outputGrid(field->region(), this->Work->reference, this->OutputSpacing),
        this->GeometryInImage);
}

void vtkInnerGSSegment::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  using innergs::Error;
  using innergs::ErrorCode;
  Internals& work = *this->Work;
  work.answers.clear();
  work.names.clear();
  work.segments.clear();
  vtkInnerGSModel* model = this->RequireModel(inputs);
  if (work.queries.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no query: name a structure, e.g. \"liver\".");
  for (const std::string& query : work.queries)
    innergs::interpret(innergs::Lexicon::standard(), query); // rejects invalid queries before the work starts
  if (!work.finder || !work.model->HasContentOf(model)) {
    work.finder.reset();
    work.finder.emplace(model->GetSegmented());
    work.model->ShallowCopy(model);
  }
  const innergs::GridGeometry grid =
      innergs::vtk::outputGrid(model->GetField()->region(), work.reference, this->OutputSpacing);
  innergs::FeatureQueryOptions options;
  options.threads = this->NumberOfThreads;
  options.stop = this->GetStopToken();
  options.progress = [this](double fraction) { this->UpdateProgress(0.9 * fraction); };
  this->SetProgressText("Segmenting");
  for (const std::int64_t n : grid.size)
    if (n > std::numeric_limits<int>::max())
      throw Error(ErrorCode::Geometry,
                  "The output grid has more voxels along an axis than an image can hold.");
  work.finder->encode(grid, options);

  std::vector<innergs::RequestedSegment> wanted;
  for (const std::string& query : work.queries) {
    work.answers.push_back(work.finder->find(query));
    std::vector<std::string> names;
    for (const innergs::SegmentCandidate& candidate : work.answers.back().candidates)
      names.push_back(work.finder->nameOf(candidate));
    work.names.push_back(std::move(names));
    for (innergs::RequestedSegment& one : work.finder->requested(query, work.answers.back()))
      wanted.push_back(std::move(one));
  }
  vtkImageData* image = vtkImageData::GetData(outputs);
  image->SetDimensions(static_cast<int>(grid.size[0]), static_cast<int>(grid.size[1]),
                       static_cast<int>(grid.size[2]));
  innergs::vtk::placeImage(image, grid, this->GeometryInImage);
  const bool wide = wanted.size() > 255;
  image->AllocateScalars(wide ? VTK_UNSIGNED_SHORT : VTK_UNSIGNED_CHAR, 1);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  scalars->SetName("Label");
  scalars->Fill(0);
  void* labels = scalars->GetVoidPointer(0);
  float* score = nullptr;
  if (this->MakeScore) {
    vtkImageData* scores = vtkImageData::GetData(outputs, 1);
    score = innergs::vtk::allocateFloats(scores, grid, this->GeometryInImage);
    std::fill_n(score, grid.voxelCount(), 0.f);
    scores->GetPointData()->GetScalars()->SetName("Probability");
  }
  const innergs::SegmentOptions segment{this->Threshold, this->Smoothing, this->LargestOnly,
                                        this->MinimumSize};
  const double voxel = grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    const innergs::Segment found =
        work.finder->probabilities()->segment(wanted[n].classes, segment, options.stop);
    const auto value = static_cast<unsigned short>(n + 1);
    innergs::forEachVoxel(found, grid.size, [&](std::size_t voxel, std::size_t part) {
      if (score) score[voxel] = std::max(score[voxel], found.probability[part]);
      if (!found.mask[part]) return;
      if (wide)
        static_cast<unsigned short*>(labels)[voxel] = value;
      else
        static_cast<unsigned char*>(labels)[voxel] = static_cast<unsigned char>(value);
    });
    work.segments.push_back({std::move(wanted[n].terms), static_cast<double>(found.voxels) * voxel});
    this->UpdateProgress(0.9 + 0.1 * static_cast<double>(n + 1) / static_cast<double>(wanted.size()));
    innergs::throwIfStopped(options.stop);
  }
  innergs::vtk::toMatrix(grid, work.outputToRAS);
}
