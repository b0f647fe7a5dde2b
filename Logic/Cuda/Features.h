#pragma once
#include "Core/Features/FeatureDevice.h"
#include "Cuda/Buffer.h"

namespace innergs::cuda {

/// Latents and codes that are learned where an executor runs.
class Features final : public FeatureDevice {
public:
  Features(std::unique_ptr<Executor> executor, const FeatureProblem& problem);

  void step(const FeatureStep& step) override;
  void download(std::span<float> latents, std::span<float> codes) override;

private:
  std::unique_ptr<Executor> executor_;
  int channels_;
  std::int64_t rows_, gaussians_, classes_, entries_ = 0, chunks_ = 0;
  Buffer<std::int64_t> rowStart_, columnStart_, blocks_, listStart_, offsets_, entryBlock_, blockStart_,
      blockRows_, chunkStart_, classStart_;
  Buffer<std::int32_t> entryPlace_;
  Buffer<std::uint16_t> lists_, targets_;
  Buffer<FeatureEntry> rowEntries_, columnEntries_;
  Buffer<float> ranks_, shares_, latents_, codes_, features_, differences_, gradients_, partial_, sums_,
      latentMoment1_, latentMoment2_, codeMoment1_, codeMoment2_;
};

} // namespace innergs::cuda
