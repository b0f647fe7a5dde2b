#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// What came out. reconstruction.judging speaks of both ways to judge: Done when all that was asked for is.
struct JudgedResult {
  ReconstructionResult reconstruction; // of the full fit, with what the judging has to say among the warnings
  std::optional<EvaluationReport> quality; // by protocol H; none when not asked for, stopped or failed
};

/// A reconstruction and, where asked for, the judging of its settings by protocol H: slices of the first
/// stack are withheld from a second fit and scored, inside the mask, beside interpolations.
class JudgedReconstruction {
public:
  /// keepEvery: the protocol keeps every so many-th slice of the first stack: 2…64, or 0: usualGap(); none:
  /// not judged so.
  JudgedReconstruction(ReconstructionInput input, Settings settings, std::optional<int> keepEvery = {});

  /// In the phase Judging the iterations are those of the second fit.
  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }
  void onPreview(std::function<void(const Volume&)> callback) { preview_ = std::move(callback); }

  /// Once. As ReconstructionJob::run(): a stop request while judging, like anything that goes wrong with it,
  /// leaves the finished fit as it is.
  JudgedResult run(const std::stop_token& stop = {}, bool renderWhenCancelled = false);

private:
  ReconstructionInput input_;
  Settings settings_;
  std::optional<int> keepEvery_;
  ProgressCallback progress_;
  std::function<void(const Volume&)> preview_;
};

/// Throws Error(InvalidArgument) unless protocol H can keep every so many-th slice.
void checkKeepEvery(int keepEvery);

/// All fits that it makes, without voxels: for estimates.
std::vector<ReconstructionInput> fitOutlines(const ReconstructionInput& input, std::optional<int> keepEvery);

} // namespace innergs
