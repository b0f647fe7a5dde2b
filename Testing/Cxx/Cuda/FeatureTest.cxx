#include "Executors.h"
#include "Features/BoxPhantom.h"
#include "RandomFields.h"

#include "Core/Features/BlockFinder.h"
#include "Core/Features/FeatureDecoder.h"
#include "Core/Features/FeatureDevices.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Features/FeatureTraining.h"
#include "Core/Features/SupportBlocks.h"
#include "Cuda/Features.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// What the iterations start from, for a phantom of labelled boxes.
struct Start {
  BoxPhantom phantom{14};
  ThreadPool pool{1};
  FeatureModel model;
  FeatureRows rows;
  std::optional<SupportLists> lists;
  FeatureProblem problem;

  explicit Start(int channels) {
    const GridGeometry& geometry = phantom.labels.geometry;
    Numbers random(4);
    std::vector<SoftLabel> labels;
    for (const std::uint16_t label : phantom.labels.voxels) {
      SoftLabel& soft = labels.emplace_back();
      soft.classes = {label, static_cast<std::uint16_t>((label + 1) % 4), 0, 0};
      soft.shares = {0.75f, label == 2 ? 0.f : 0.25f, 0, 0};
    }
    model.channels = channels;
    model.names = {"background", "a", "b", "c"};
    model.labels = {0, 1, 2, 3};
    model.support = supportOf(geometry, labels, 4, pool);
    for (std::size_t n = 0; n < 4 * FeatureModel::kTerms * static_cast<std::size_t>(channels); ++n)
      model.codes.push_back(static_cast<float>(random(-1, 1)));
    for (std::size_t n = 0; n < phantom.field.gaussians.size() * static_cast<std::size_t>(channels); ++n)
      model.latents.push_back(static_cast<float>(random(-1, 1)));
    const FeatureRenderer renderer(phantom.field, sampleGridOf(geometry, phantom.field.modelToWorld), pool);
    std::vector<std::uint8_t> chosen(phantom.field.gaussians.size(), 1);
    for (std::size_t g = 0; g < chosen.size(); g += 3)
      chosen[g] = 0;
    rows = rowsOf(renderer, chosen, geometry.voxelCount(), phantom.field, pool);
    lists.emplace(model.support);
    const BlockFinder blockOf(model.support.blocks, geometry.indexToWorld());
    problem = {channels, model.latents, model.codes, &rows, &*lists, {}, {}, {}};
    for (const std::int64_t v : rows.voxels) {
      problem.ranks.push_back(static_cast<float>(random(-0.5, 1)));
      problem.labels.push_back(labels[static_cast<std::size_t>(v)]);
      problem.blocks.push_back(blockOf(
          {static_cast<double>(v % 14), static_cast<double>(v / 14 % 14), static_cast<double>(v / 196)}));
    }
  }

  /// The cross-entropy's gradients with respect to latents and codes, by the CPU's decoder.
  template <int N>
  void gradients(std::vector<float>& latents, std::vector<float>& codes) const {
    latents.assign(model.latents.size(), 0.f);
    codes.assign(model.codes.size(), 0.f);
    std::vector<float> difference(lists->longest());
    for (std::int64_t row = 0; row < std::ssize(rows.voxels); ++row) {
      float latent[N] = {}, gradient[N] = {};
      rows.forRow(row, [&](std::uint32_t g, float weight) {
        for (int n = 0; n < N; ++n)
          latent[n] += weight * model.latents[g * N + n];
      });
      const auto classes = lists->of(problem.blocks[row]);
      decode<N>(model, latent, problem.ranks[row], classes, difference.data());
      for (int s = 0; s < SoftLabel::kClasses; ++s)
        for (std::size_t c = 0; c < classes.size(); ++c)
          if (problem.labels[row].shares[s] > 0 && classes[c] == problem.labels[row].classes[s])
            difference[c] -= problem.labels[row].shares[s];
      decodeBackward<N>(model, latent, problem.ranks[row], classes, difference.data(), gradient,
                        codes.data());
      rows.forRow(row, [&](std::uint32_t g, float weight) {
        for (int n = 0; n < N; ++n)
          latents[g * N + n] += weight * gradient[n];
      });
    }
  }
};

class LearningFeatures : public ::testing::TestWithParam<Where> {};

/// A step that subtracts the gradient itself: Adam's division by the second moment is made to vanish.
constexpr FeatureStep kPlainStep{1e-6f, 1e-6f, 1 - FeatureStep::kMomentum, 1e30f};

template <int N>
void hasTheGradientsOfTheCpu(std::unique_ptr<cuda::Executor> executor) {
  const Start start(N);
  std::vector<float> latents, codes;
  start.gradients<N>(latents, codes);
  cuda::Features device(std::move(executor), start.problem);
  std::vector<float> movedLatents(latents.size()), movedCodes(codes.size());
  device.step(kPlainStep);
  device.download(movedLatents, movedCodes);
  for (std::size_t n = 0; n < latents.size(); ++n)
    movedLatents[n] = start.model.latents[n] - movedLatents[n];
  for (std::size_t n = 0; n < codes.size(); ++n)
    movedCodes[n] = start.model.codes[n] - movedCodes[n];
  EXPECT_LE(relativeError(movedLatents, latents), 1e-4);
  EXPECT_LE(relativeError(movedCodes, codes), 1e-4);
  std::int64_t still = 0;
  for (std::int64_t g = 0; g < start.rows.columns(); ++g)
    still += start.rows.isEmpty(g);
  EXPECT_LT(still, start.rows.columns());
}

TEST_P(LearningFeatures, HasTheGradientsOfTheCpuWith8Channels) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  hasTheGradientsOfTheCpu<8>(std::move(executor));
}
TEST_P(LearningFeatures, HasTheGradientsOfTheCpuWith16Channels) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  hasTheGradientsOfTheCpu<16>(std::move(executor));
}
TEST_P(LearningFeatures, HasTheGradientsOfTheCpuWith32Channels) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  hasTheGradientsOfTheCpu<32>(std::move(executor));
}

/// One executor's features, as trainFeatures() asks for them.
class OneDevice final : public FeatureDevices {
public:
  explicit OneDevice(std::unique_ptr<cuda::Executor> executor) : executor_(std::move(executor)) {}
  std::unique_ptr<FeatureDevice> make(const FeatureProblem& problem, int, const std::stop_token&) override {
    return std::make_unique<cuda::Features>(std::move(executor_), problem);
  }
  void failed(const std::string& why) override { FAIL() << why; }

private:
  std::unique_ptr<cuda::Executor> executor_;
};

TEST_P(LearningFeatures, GivesTheLatentsOfTheCpu) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  const BoxPhantom phantom(20);
  FeatureTraining training;
  training.threads = 1;
  training.iterations = 5;
  const Labelmap labels = phantom.every(4);
  const FeatureModel cpu = trainFeatures(phantom.field, labels, {}, training);
  training.devices = std::make_shared<OneDevice>(std::move(executor));
  const FeatureModel device = trainFeatures(phantom.field, labels, {}, training);
  EXPECT_LE(relativeLength(device.latents, cpu.latents), 1e-3);
  EXPECT_LE(relativeLength(device.codes, cpu.codes), 1e-3);
  training.iterations = 6;
  training.devices = nullptr;
  const FeatureModel further = trainFeatures(phantom.field, labels, {}, training);
  EXPECT_GT(relativeLength(further.latents, cpu.latents), 1e-3) << "an iteration more is told apart";
}

INSTANTIATE_TEST_SUITE_P(Kernels, LearningFeatures, ::testing::ValuesIn(kEverywhere),
                         [](const auto& info) { return whereName(info.param); });

} // namespace
