#pragma once
#include "Core/Fit/FitDevice.h"
#include "Core/Render/GridRenderer.h"

namespace innergs {

/// Fits on the CPU: the reference, and the fallback of every fit. Bit-identical for any number of threads.
class CpuFitDevice : public FitDevice {
public:
  /// Stops when the pool is stopped; ignores the request's token.
  CpuFitDevice(const FitRequest& request, const KernelSet& kernels, ThreadPool& pool);
  ~CpuFitDevice() override;

  void upload(const GaussianField& field, const Adam& adam, const GradientAccumulator& accumulator) override;
  void take(FitState&& state) override { state_ = std::move(state); }
  void download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) override;
  const FitState* resident() const override { return &state_; }

  LossSum iterate(const IterationOptions& options) override;
  DensifyCounts densify() override;
  LossSum evaluate(const GaussianField& field) override;
  LossSum gradient(const GaussianField& field, std::int64_t observation, std::span<float> gradient) override;

private:
  struct View {
    const Observation* observation;
    std::vector<std::shared_ptr<GridRenderer>> renderers; // one per point; shared by views of one grid
  };
  void addView(const Observation& observation, std::vector<View>& views);
  LossSum addLoss(View& view, const GaussianField& field, std::span<float> gradient,
                  const GaussianBlocks* blocks = nullptr);
  const GaussianBlocks* blocksOf(const GaussianField& field);

  FitRules rules_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  std::vector<GridRenderer::Scratch> scratch_; // one per point
  std::shared_ptr<const std::vector<Observation>> observations_;
  std::vector<Observation> halves_;
  std::vector<View> fine_, coarse_;
  std::vector<float> weights_, numerators_, gradient_;
  GaussianBlocks blocks_;
  FitState state_;
};

} // namespace innergs
