#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Cuda/Passes.h"
#include "Cuda/Reshape.h"

namespace innergs::cuda {

/// The iterations of a fit where an executor runs. Field, moments and gradients stay there; iterations are
/// synchronised in batches, for their sums. What does not fit is cut into smaller slabs of slices.
class Fit final : public FitDevice {
public:
  /// Throws Error(Memory) if not even the smallest slabs fit.
  Fit(std::unique_ptr<Executor> executor, const FitRequest& request);
  ~Fit() override;

  void upload(const GaussianField& field, const Adam& adam, const GradientAccumulator& accumulator) override;
  void download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) override;
  LossSum iterate(const IterationOptions& options) override;
  std::vector<LossSum> iterateMany(std::span<const IterationOptions> iterations) override;
  DensifyCounts densify() override;
  LossSum evaluate(const GaussianField& field) override;
  LossSum gradient(const GaussianField& field, std::int64_t observation, std::span<float> gradient) override;
  std::string remark() const override;

  int slabs() const; // total, of the finest observations
  Executor& executor() { return *executor_; }

private:
  struct Slab;
  struct View;

  void addViews(const std::vector<Observation>& observations, std::vector<View>& views);
  void cut(std::vector<View>& views);
  bool smaller();
  void throwIfStopped() const;
  void enqueue(std::span<View> views, const GaussianField& numbers, const Gaussian* gaussians,
               std::int64_t count, bool backward, int iteration, int subset);
  void queue(const IterationOptions& options, int slot);
  std::vector<LossSum> settled(int queued, bool updating);
  LossSum measure(std::span<View> views, const GaussianField& field, std::span<float> gradient);
  template <class Work>
  void withMemory(const Work& work);

  std::unique_ptr<Executor> executor_;
  FitRules rules_;
  std::stop_token stop_;
  std::int64_t slabPoints_;
  std::vector<View> fine_, coarse_;
  Passes passes_;
  GaussianField numbers_; // without Gaussians
  double beta1_ = 0.9, beta2_ = 0.99;
  bool gradientSums_ = false;
  int accumulatedIterations_ = 0;
  FitBuffers state_;
  Relocation relocation_;
  Buffer<Gaussian> others_;
  Buffer<float> gradient_;
};

} // namespace innergs::cuda
