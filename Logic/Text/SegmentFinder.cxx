#include "Text/SegmentFinder.h"

#include "Core/Base/Error.h"
#include "Core/Motion/DynamicFeatures.h"
#include "Text/SentenceEncoder.h"

#include <algorithm>
#include <cmath>

namespace innergs {

SegmentTerms termsOf(const Lexicon& lexicon, const std::string& name, int index) {
  SegmentTerms terms;
  terms.name = name;
  const double hue = std::fmod(0.61803398875 * index, 1.0) * 6;
  const auto channel = [&](double shift) {
    return 0.35 + 0.6 * std::clamp(std::abs(std::fmod(hue + shift, 6.0) - 3) - 1, 0.0, 1.0);
  };
  terms.color = {channel(0), channel(4), channel(2)};
  const auto read = interpret(lexicon, name);
  if (!read.empty() && read[0].score == 1 && read[0].structures.size() == 1) {
    const Structure& structure = read[0].structures[0];
    terms.code = lexicon.codeOf(structure);
    terms.meaning = lexicon.meaningOf(structure);
    terms.side = structure.side;
  }
  return terms;
}

std::string terminologyEntry(const SegmentTerms& terms) {
  if (terms.code.empty()) return {};
  const char* side = terms.side == Side::Left    ? "SCT^7771000^Left"
                     : terms.side == Side::Right ? "SCT^24028007^Right"
                                                 : "^^";
  return "Segmentation category and type - DICOM master list~SCT^123037004^Anatomical Structure~SCT^" +
         terms.code + "^" + terms.meaning + "~" + side + "~Anatomic codes - DICOM master list~^^~^^";
}

SegmentFinder::SegmentFinder(SegmentedModel model) : model_(std::move(model)) {
  if (!model_.features || !(model_.dynamic || model_.field))
    throw Error(ErrorCode::NoData,
                "The model knows no segments yet: let it learn them from a labelmap or segmentation first.");
  if (model_.dynamic)
    model_.field = std::make_shared<const GaussianField>(featureFieldAt(*model_.dynamic, model_.time));
  makeSearch();
}

void SegmentFinder::makeSearch() {
  std::vector<NamedSegment> scene;
  for (int c = 1; c < model_.features->classes(); ++c)
    scene.push_back({model_.features->names[static_cast<std::size_t>(c)],
                     !probabilities_ || probabilities_->voxels(c) > 0});
  search_.emplace(Lexicon::standard(), std::move(scene), sentenceModel);
}

void SegmentFinder::encode(const GridGeometry& geometry, const FeatureQueryOptions& options) {
  if (probabilities_ && probabilities_->geometry() == geometry) return;
  probabilities_.reset(); // frees its memory first
  probabilities_.emplace(
      *model_.field, *model_.features, geometry,
      model_.dynamic ? queryAt(*model_.dynamic, model_.time, model_.features->time, options) : options);
  makeSearch();
}

const std::string& SegmentFinder::nameOf(const SegmentCandidate& candidate) const {
  return model_.features->names[static_cast<std::size_t>(candidate.segment) + 1];
}

MadeSegments SegmentFinder::make(const std::vector<RequestedSegment>& requested,
                                 const SegmentOptions& options, const std::stop_token& stop) const {
  if (!probabilities_)
    throw Error(ErrorCode::InvalidArgument, "The segments were not decoded on a grid yet: encode one first.");
  MadeSegments made{probabilities_->geometry(), {}};
  for (const RequestedSegment& one : requested)
    made.segments.emplace_back(one.terms, probabilities_->segment(one.classes, options, stop));
  return made;
}

RequestedSegment SegmentFinder::requested(const SegmentCandidate& candidate) const {
  return {termsOf(Lexicon::standard(), nameOf(candidate), candidate.segment + 1), {candidate.segment + 1}};
}

std::vector<RequestedSegment> SegmentFinder::requested(std::string_view query,
                                                       const SegmentAnswer& answer) const {
  std::vector<RequestedSegment> all;
  if (answer.kind != AnswerKind::Found && answer.kind != AnswerKind::Several) return all;
  for (std::size_t n = 0; n < answer.leading; ++n)
    all.push_back(requested(answer.candidates[n]));
  if (answer.kind == AnswerKind::Several || all.size() < 2) return all; // never one of them alone
  RequestedSegment together{termsOf(Lexicon::standard(), std::string(query), all[0].classes[0]), {}};
  for (const RequestedSegment& one : all)
    together.classes.push_back(one.classes[0]);
  return {together};
}

} // namespace innergs
