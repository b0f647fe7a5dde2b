#include "Core/Features/EmbeddingTraining.h"
#include "Core/Base/Random.h"
#include "Core/Features/ClassProbabilities.h"
#include "Features/BoxPhantom.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

#include <limits>

namespace innergs::testing {
namespace {

constexpr int kSize = 40;

std::vector<float> direction(int seed) {
  Random random(static_cast<std::uint64_t>(seed) + 100);
  std::vector<float> values;
  for (int i = 0; i < kSize; ++i)
    values.push_back(static_cast<float>(2 * random.uniform() - 1));
  return values;
}

/// Each label's own embedding, of any length and with noise.
EmbeddingVolume teacherOf(const Labelmap& labels) {
  EmbeddingVolume teacher{labels.geometry, {}};
  teacher.channels.resize(kSize);
  Random random(9);
  for (const std::uint16_t label : labels.voxels) {
    const std::vector<float> own = direction(label);
    const auto length = static_cast<float>(1 + random.uniform());
    for (int c = 0; c < kSize; ++c)
      teacher.channels[c].push_back(length * (own[c] + 0.1F * static_cast<float>(random.uniform())));
  }
  return teacher;
}

const std::vector<TextEmbedding> kTexts{{"Background", direction(0)},
                                        {"liver", direction(1)},
                                        {"spleen", direction(2)},
                                        {"kidney", direction(3)},
                                        {"bicycle", direction(77)}};

TEST(EmbeddingTraining, TextsFindTheirBoxes) {
  const BoxPhantom phantom;
  const FeatureModel model = trainEmbeddings(phantom.field, teacherOf(phantom.labels), kTexts);
  EXPECT_EQ(model.names, (std::vector<std::string>{"background", "liver", "spleen", "kidney", "bicycle"}));
  EXPECT_NO_THROW(checkFeatures(model, phantom.field));
  const ClassImage image = classify(phantom.field, model, phantom.labels.geometry);
  int wrong = 0;
  for (std::size_t v = 0; v < image.classes.size(); ++v)
    wrong += image.classes[v] != phantom.labels.voxels[v];
  EXPECT_EQ(wrong, 0);
  const ClassProbabilities probabilities(phantom.field, model, phantom.labels.geometry);
  EXPECT_EQ(probabilities.voxels(4), 0); // no bicycle
  EXPECT_EQ(probabilities.segment(std::vector<int>{2}).voxels,
            std::count(phantom.labels.voxels.begin(), phantom.labels.voxels.end(), 2));
}

TEST(EmbeddingTraining, LossGradientIsTheDifferenceQuotient) {
  FeatureModel model;
  model.names.resize(4);
  model.decoder.emplace().size = kSize;
  for (int c = 0; c < 4; ++c) {
    const std::vector<float> own = direction(c);
    float square = 0;
    for (const float x : own)
      square += x * x;
    for (const float x : own)
      model.embeddings.push_back(x / std::sqrt(square));
  }
  // Near one direction the softmax is saturated: between two of them it is not.
  std::vector<float> e;
  for (int i = 0; i < kSize; ++i)
    e.push_back(0.5F * (model.embeddings[kSize + i] + 1.02F * model.embeddings[3 * kSize + i]));
  const std::vector<std::uint16_t> classes{1, 2, 3};
  for (const int truth : {1, 2, 3}) {
    std::vector<float> gradient(kSize, 0.F), unused = gradient;
    embeddingLoss(model, e.data(), classes, truth, gradient.data());
    double largest = 0;
    for (int i = 0; i < kSize; ++i) {
      const float before = e[i];
      constexpr float step = 1e-3F;
      e[i] = before + step;
      const double high = embeddingLoss(model, e.data(), classes, truth, unused.data());
      e[i] = before - step;
      const double low = embeddingLoss(model, e.data(), classes, truth, unused.data());
      e[i] = before;
      const double quotient = (high - low) / (2 * static_cast<double>(step));
      EXPECT_NEAR(gradient[i], quotient, 0.02 + 0.01 * std::fabs(quotient)) << truth << ' ' << i;
      largest = std::max(largest, std::fabs(quotient));
    }
    EXPECT_GT(largest, 1) << truth;
  }
}

TEST(EmbeddingTraining, VoxelsWithoutAnEmbeddingAreLeftOut) {
  const BoxPhantom phantom;
  EmbeddingVolume teacher = teacherOf(phantom.labels);
  for (std::size_t v = 0; v < phantom.labels.voxels.size(); v += 5)
    for (auto& channel : teacher.channels)
      channel[v] = v % 2 ? 0 : std::numeric_limits<float>::quiet_NaN();
  const FeatureModel model = trainEmbeddings(phantom.field, teacher, kTexts);
  const ClassImage image = classify(phantom.field, model, phantom.labels.geometry);
  int wrong = 0;
  for (std::size_t v = 0; v < image.classes.size(); ++v)
    wrong += v % 5 != 0 && image.classes[v] != phantom.labels.voxels[v];
  EXPECT_EQ(wrong, 0);
}

TEST(EmbeddingTraining, SameBitsAtAnyNumberOfThreads) {
  const BoxPhantom phantom(8);
  EmbeddingTraining training;
  training.threads = 1;
  const FeatureModel one = trainEmbeddings(phantom.field, teacherOf(phantom.labels), kTexts, training);
  training.threads = 3;
  const FeatureModel three = trainEmbeddings(phantom.field, teacherOf(phantom.labels), kTexts, training);
  EXPECT_EQ(one.latents, three.latents);
  EXPECT_EQ(one.decoder->parameters, three.decoder->parameters);
}

TEST(EmbeddingTraining, ReportsProgressAndStops) {
  const BoxPhantom phantom(8);
  std::stop_source stop;
  double last = 0;
  EmbeddingTraining training;
  training.stop = stop.get_token();
  training.progress = [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    if (fraction > 0.7) stop.request_stop();
  };
  EXPECT_EQ(
      test::codeOf([&] { trainEmbeddings(phantom.field, teacherOf(phantom.labels), kTexts, training); }),
      ErrorCode::Cancelled);
  EXPECT_LT(last, 1);
}

TEST(EmbeddingTraining, BadInputIsRefused) {
  const BoxPhantom phantom(8);
  const EmbeddingVolume teacher = teacherOf(phantom.labels);
  const auto code = [&](const EmbeddingVolume& volume, const std::vector<TextEmbedding>& texts) {
    return test::codeOf([&] { trainEmbeddings(phantom.field, volume, texts); });
  };
  EXPECT_EQ(code(teacher, {}), ErrorCode::InvalidArgument);
  EXPECT_EQ(code(teacher, {{"background", direction(0)}}), ErrorCode::InvalidArgument);
  EXPECT_EQ(code(teacher, {{"liver", {1, 2}}}), ErrorCode::InvalidArgument);
  EXPECT_EQ(code(teacher, {{"liver", std::vector<float>(kSize, 0.F)}}), ErrorCode::InvalidArgument);
  EmbeddingVolume away = teacher;
  away.geometry.origin[0] += 500;
  EXPECT_EQ(code(away, kTexts), ErrorCode::NoData);
  EmbeddingVolume cut = teacher;
  cut.channels[3].pop_back();
  EXPECT_EQ(code(cut, kTexts), ErrorCode::InvalidArgument);
}

} // namespace
} // namespace innergs::testing
