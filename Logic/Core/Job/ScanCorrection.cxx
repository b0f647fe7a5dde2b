#include "Core/Job/ScanCorrection.h"

#include "Core/Acquisition/BlankSlices.h"
#include "Core/Acquisition/InterleaveGain.h"
#include "Core/Acquisition/Padding.h"
#include "Core/Alignment/EdgeBlending.h"
#include "Core/Alignment/PairedSums.h"
#include "Core/Job/JobInput.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

constexpr double kAnotherBody = 0.3;             // correlation below which two scans show different bodies
constexpr double kAgree = 28, kBlendedEdge = 12; // dB, mm
constexpr double kPaddingMargin = 8;             // mm, by which slices may have moved

} // namespace

ScanCorrection::ScanCorrection(const ReconstructionInput& input, const Settings& settings, bool keepsVoxels,
                               JobProgress& progress, ThreadPool& pool)
    : input_(input), settings_(settings), keepsVoxels_(keepsVoxels), progress_(progress), pool_(pool) {}

std::vector<std::string> ScanCorrection::apply(std::span<Stack> stacks) {
  std::vector<std::string> said = correctSlices(stacks);
  if (settings_.n4)
    for (Stack& stack : stacks) {
      said.push_back(input_.n4(stack, !input_.masks.empty(), pool_.stopToken()));
      if (keepsVoxels_) voxels_.push_back(stack.image.voxels);
    }
  if (stacks.size() < 2) return said;
  const BiasCorrection left = alignScans(stacks);
  std::vector<Stack> even; // without that shading, which would be taken for motion
  if (!left.scans.empty()) {
    even.assign(stacks.begin(), stacks.end());
    for (std::size_t s = 0; s < even.size(); ++s)
      applyBias(left.scans[s], even[s], pool_);
  }
  compareScans(stacks, even);
  moveSlices(stacks, even);
  if (settings_.blendEdges) blendWhatDiffers(stacks);
  const std::vector<std::string> more = sentences(stacks, left);
  said.insert(said.end(), more.begin(), more.end());
  return said;
}

/// What concerns the slices of each scan alone.
std::vector<std::string> ScanCorrection::correctSlices(std::span<Stack> stacks) {
  std::vector<std::string> said;
  padded_.assign(stacks.size(), {});
  blank_.assign(stacks.size(), {});
  interleaveGain_.assign(stacks.size(), 1);
  if (settings_.preset == Preset::Paper) return said;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    if (settings_.ignorePadding) blank_[s] = blankSlices(stacks[s]);
    leaveOutNotAcquired(s, stacks[s].observed);
    if (settings_.evenInterleaves) interleaveGain_[s] = interleaveGain(stacks[s], pool_);
    evenOutInterleaves(interleaveGain_[s], stacks[s]);
    const std::string name = nameOf(stacks[s], s);
    for (const std::string& sentence :
         std::array{blankSlicesSentence(blank_[s], name), interleaveGainSentence(interleaveGain_[s], name)})
      if (!sentence.empty()) said.push_back(sentence);
  }
  return said;
}

std::vector<std::string> ScanCorrection::sentences(std::span<const Stack> stacks,
                                                   const BiasCorrection& left) const {
  std::vector<std::string> said, names;
  const auto add = [&](const std::string& sentence) {
    if (!sentence.empty()) said.push_back(sentence);
  };
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    names.push_back(nameOf(stacks[s], s));
    add(paddingSentence(padded_[s], names[s]));
    if (!input_.stacks[s].poses.empty() && (settings_.align || settings_.sliceMotion != SliceMotionKind::Off))
      add(names[s] + " has slices with poses of their own: it is used where they put it and takes no part in "
                     "the alignment, and no slices are moved.");
    if (!alignment_.empty() && alignment_[s].fits) add(alignmentSentence(alignment_[s], names[s]));
    add(misfitSentence(agreement_[s], names[s], motion_.moved));
  }
  for (std::size_t s = 0; s < bias_.scans.size(); ++s)
    add(biasSentence(bias_.scans[s], names[s]));
  add(biasSentence(bias_, settings_.keepBias ? names.front() : std::string()));
  add(shadingSentence(left));
  add(sliceMotionSentence(motion_, names));
  return said;
}

/// Aligns whole scans and evens out their shading. Returns shading that was found but is left in them.
BiasCorrection ScanCorrection::alignScans(std::span<Stack> stacks) {
  progress_.report(Phase::Aligning, 0);
  findPlaces(stacks);
  BiasCorrection left;
  if (settings_.biasField != BiasFieldKind::Off)
    bias_ = findBias(stacks, alignment_, settings_.biasField == BiasFieldKind::On, pool_);
  else if (settings_.align) // where scans lie apart, their differences look like shading
    left = findShading(stacks, alignment_, pool_);
  if (settings_.align) applyAlignment(alignment_, stacks);
  for (std::size_t s = 0; s < stacks.size(); ++s)
    evenOut(s, stacks[s]);
  return left;
}

/// Finds the places of whole scans and what of them is padding, which becomes unobserved.
void ScanCorrection::findPlaces(std::span<Stack> stacks) {
  std::vector<std::vector<std::uint8_t>> observed;
  for (const Stack& stack : stacks)
    observed.push_back(stack.observed);
  const auto leavePaddingOut = [&] {
    for (std::size_t s = 0; s < stacks.size(); ++s) {
      stacks[s].observed = observed[s];
      leaveOutNotAcquired(s, stacks[s].observed);
    }
  };
  findPadding(stacks);
  leavePaddingOut();
  if (!settings_.align) return;
  alignment_ = alignStacks(stacks, pool_);
  const auto stays = [](const StackAlignment& a) { return a.fits && a.displacement == 0; };
  if (std::all_of(alignment_.begin(), alignment_.end(), stays)) return;
  const std::vector<std::vector<std::uint8_t>> before = padded_;
  findPadding(stacks);
  leavePaddingOut();
  // Scans that lie apart may look padded, and alone fit no better for it.
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (padded_[s].empty() && !before[s].empty()) {
      alignment_ = alignStacks(stacks, pool_);
      break;
    }
}

void ScanCorrection::leaveOutNotAcquired(std::size_t scan, std::vector<std::uint8_t>& observed) const {
  const std::vector<std::uint8_t>& padded = padded_[scan];
  const Volume& image = input_.stacks[scan].image;
  if (observed.empty() && !(padded.empty() && blank_[scan].empty())) observed.assign(image.voxels.size(), 1);
  for (std::size_t v = 0; v < padded.size(); ++v)
    if (padded[v]) observed[v] = 0;
  const std::int64_t plane = image.geometry.size[0] * image.geometry.size[1];
  for (const std::int64_t k : blank_[scan])
    std::fill_n(observed.begin() + k * plane, plane, std::uint8_t{0});
}

/// Finds padding where the scans lie as far as that is known.
void ScanCorrection::findPadding(std::span<const Stack> stacks) {
  if (!settings_.ignorePadding) return;
  std::vector<Affine3> places(stacks.size());
  for (std::size_t s = 0; s < alignment_.size(); ++s)
    places[s] = alignment_[s].toOthers;
  std::vector<std::size_t> part; // without scans that may show something else
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (alignment_.empty() || alignment_[s].fits) part.push_back(s);
  padded_ = paddedVoxels(stacks, part, places, kPaddingMargin, pool_);
}

/// Divides an aligned stack by its bias field, or gives it that of the first.
void ScanCorrection::evenOut(std::size_t scan, Stack& stack) const {
  if (!bias_.scans.empty())
    applyBias(bias_.scans[scan], stack, pool_, settings_.keepBias ? &bias_.scans.front() : nullptr);
}

/// Measures how well the scans agree as they lie. even: the same without their shading; none: they have none.
void ScanCorrection::compareScans(std::span<const Stack> stacks, std::span<const Stack> even) {
  const bool aligned = !alignment_.empty();
  agreement_ = aligned && even.empty() ? agreementsOf(alignment_) : compareStacks(stacks, pool_);
  if (even.empty()) return;
  const std::vector<StackAgreement> same = aligned ? agreementsOf(alignment_) : compareStacks(even, pool_);
  for (std::size_t s = 0; s < same.size(); ++s)
    agreement_[s].fits = same[s].fits;
}

/// Moves the stacks' slices to where they agree best, as found in `even` if that is not empty.
void ScanCorrection::moveSlices(std::span<Stack> stacks, std::span<const Stack> even) {
  if (!correctsSlices(settings_, stacks)) return;
  // Slices of another body can only be moved to where they happen to look alike.
  if (differentBodies() && settings_.sliceMotion == SliceMotionKind::Auto) return;
  progress_.report(Phase::Aligning, 0);
  motion_ = findSliceMotion(
      even.empty() ? std::span<const Stack>(stacks) : even,
      {settings_.sliceMotion == SliceMotionKind::On, settings_.packets}, pool_,
      [&](double done) { progress_.report(Phase::Aligning, motionEnds(settings_.preset) * done); });
  applySliceMotion(motion_, stacks);
  for (std::size_t s = 0; motion_.moved && s < stacks.size(); ++s) {
    StackAgreement& mine = agreement_[s];
    mine.correlation = motion_.scans[s].correlation;
    mine.psnr = motion_.scans[s].psnr;
    mine.ratio = 1;
    mine.fits = mine.fits || mine.correlation >= kSameTissue;
  }
}

/// Scans that agree leave no steps where one of them ends.
void ScanCorrection::blendWhatDiffers(std::span<Stack> stacks) const {
  std::vector<std::size_t> part;
  bool differ = false;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    if (!agreement_[s].fits) continue;
    part.push_back(s);
    differ = differ || agreement_[s].psnr < kAgree;
  }
  if (differ && !motion_.moved) blendEdges(stacks, part, kBlendedEdge, pool_);
}

void ScanCorrection::report(ReconstructionResult& result) const {
  result.alignment = alignment_;
  result.bias = bias_;
  result.agreement = agreement_;
  result.sliceMotion = motion_;
}

double ScanCorrection::disagreement() const {
  return motion_.moved && std::isfinite(motion_.psnrAfter) ? std::pow(10, -motion_.psnrAfter / 20) : 0;
}

bool ScanCorrection::differentBodies() const {
  return std::any_of(alignment_.begin(), alignment_.end(),
                     [](const auto& a) { return !a.fits && !(a.correlation >= kAnotherBody); });
}

Stack ScanCorrection::placed(std::size_t scan, std::span<const std::int64_t> heldOut,
                             const std::function<Volume(const GridGeometry&)>& render, bool scales) const {
  std::vector<Stack> whole{input_.stacks[scan]};
  Stack& stack = whole.front();
  if (!voxels_.empty())
    stack.image.voxels = voxels_[scan];
  else
    evenOutInterleaves(interleaveGain_[scan], stack);
  if (!alignment_.empty()) applyAlignment(std::span(&alignment_[scan], 1), whole);
  evenOut(scan, stack);
  if (!motion_.moved) return std::move(stack);
  SliceMotion motion;
  motion.moved = true;
  motion.slices.push_back(motion_.slices[scan]);
  const std::vector<SlicePose> found = placeSlices(render, stack, heldOut, scales, pool_);
  for (std::size_t n = 0; n < heldOut.size(); ++n)
    motion.slices.front()[static_cast<std::size_t>(heldOut[n])] = found[n];
  applySliceMotion(motion, whole);
  return std::move(stack);
}

} // namespace innergs
