#pragma once
#include "Core/Job/JobProgress.h"
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// Leaves out blank slices of scans and evens out interleaved ones, and makes several scans of one body agree
/// before the fit: leaves out their padding, corrects their shading,
/// aligns whole scans and moves their slices, as far as the settings ask for it; measures how well they agree
/// in any case.
class ScanCorrection {
public:
  /// Everything must outlive the correction. keepsVoxels: placed() is called later.
  ScanCorrection(const ReconstructionInput& input, const Settings& settings, bool keepsVoxels,
                 JobProgress& progress, ThreadPool& pool);

  /// Corrects the input's stacks as they were prepared, one per scan. Returns sentences for the user. Throws
  /// Error(Cancelled).
  std::vector<std::string> apply(std::span<Stack> stacks);

  /// After apply(): writes what was found into a result.
  void report(ReconstructionResult& result) const;
  /// After apply(): what slices miss in each other as a share of the range, where they were moved; otherwise
  /// 0.
  double disagreement() const;
  /// After apply(): whether the alignment found scans of different bodies.
  bool differentBodies() const;

  /// What was not acquired of a scan becomes unobserved: its padding (paddedVoxels()) and its blankSlices(),
  /// as far as they were found.
  void leaveOutNotAcquired(std::size_t scan, std::vector<std::uint8_t>& observed) const;

  /// After apply(): one whole scan of the input, corrected. Slices `heldOut` (K) from apply() get the pose
  /// at which they fit a volume that was made without them. render: that volume on a grid of cubes.
  /// scales: looks for their gains, too.
  Stack placed(std::size_t scan, std::span<const std::int64_t> heldOut,
               const std::function<Volume(const GridGeometry&)>& render, bool scales) const;

private:
  std::vector<std::string> correctSlices(std::span<Stack> stacks);
  BiasCorrection alignScans(std::span<Stack> stacks);
  void findPlaces(std::span<Stack> stacks);
  void findPadding(std::span<const Stack> stacks);
  void evenOut(std::size_t scan, Stack& stack) const;
  void compareScans(std::span<const Stack> stacks, std::span<const Stack> even);
  void moveSlices(std::span<Stack> stacks, std::span<const Stack> even);
  void blendWhatDiffers(std::span<Stack> stacks) const;
  std::vector<std::string> sentences(std::span<const Stack> stacks, const BiasCorrection& left) const;

  const ReconstructionInput& input_;
  const Settings& settings_;
  const bool keepsVoxels_;
  JobProgress& progress_;
  ThreadPool& pool_;
  std::vector<std::vector<float>> voxels_;        // of the scans after N4, if kept
  std::vector<std::vector<std::uint8_t>> padded_; // of each scan
  std::vector<std::vector<std::int64_t>> blank_;  // of each scan
  std::vector<double> interleaveGain_;            // of each scan
  std::vector<StackAlignment> alignment_;
  BiasCorrection bias_;
  std::vector<StackAgreement> agreement_;
  SliceMotion motion_;
};

} // namespace innergs
