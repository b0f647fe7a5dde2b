#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// The outcome. reconstruction.judging covers both ways to judge the quality: Done if all requested ones are.
struct JudgedResult {
  ReconstructionResult reconstruction;     // of the full fit; includes the judging's warnings
  std::optional<EvaluationReport> quality; // by protocol H; empty if not requested, stopped or failed
};

/// A reconstruction and, on request, the quality of its settings by protocol H: slices of the first
/// stack are held out from a second fit and scored, inside the mask, next to interpolations.
class JudgedReconstruction {
public:
  /// keepEvery: the protocol keeps every keepEvery-th slice of the first stack: 2…64, or 0: usualGap(); none:
  /// no judging by protocol H.
  JudgedReconstruction(ReconstructionInput input, Settings settings, std::optional<int> keepEvery = {});

  /// During the phase Judging, the iterations are those of the second fit.
  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }
  void onPreview(std::function<void(const Volume&)> callback) { preview_ = std::move(callback); }

  /// Runs once, like ReconstructionJob::run(). A stop request or a failure during the judging
  /// leaves the finished fit as it is.
  JudgedResult run(const std::stop_token& stop = {}, bool renderWhenCancelled = false);

private:
  ReconstructionInput input_;
  Settings settings_;
  std::optional<int> keepEvery_;
  ProgressCallback progress_;
  std::function<void(const Volume&)> preview_;
};

/// Throws Error(InvalidArgument) unless protocol H can keep every keepEvery-th slice.
void checkKeepEvery(int keepEvery);

/// All fits that it makes, without voxels, for estimates.
std::vector<ReconstructionInput> fitOutlines(const ReconstructionInput& input, std::optional<int> keepEvery);

} // namespace innergs
