#include "Core/Features/FeatureQuery.h"
#include "IO/ModelFile.h"
#include "TestFiles.h"

#include "TestFields.h"

namespace innergs::test {
namespace {

/// Arbitrary features that use every bit.
FeatureModel featuresFor(const GaussianField& field, int channels = 16) {
  FeatureModel f;
  f.channels = channels;
  f.names = {"background", "liver", "Niere \xC3\xA4 \"links\""};
  f.labels = {0, 5, 65535};
  const auto fill = [](std::vector<float>& values, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n)
      values.push_back(std::sin(1.f + static_cast<float>(n)) / 3);
  };
  fill(f.latents, field.gaussians.size() * static_cast<std::size_t>(channels));
  fill(f.codes, 3 * FeatureModel::kTerms * static_cast<std::size_t>(channels));
  f.scale.low = -1000.1f;
  f.scale.knots = {-3.3f, 0.1f, 7};
  f.support.blocks = field.domain;
  f.support.blocks.size = {3, 4, 5};
  f.support.words = 1;
  for (std::uint32_t b = 0; b < 60; ++b)
    f.support.bits.push_back(b % 8);
  f.residual.grid = field.domain;
  f.residual.voxels = {3, 17};
  f.residual.ends = {1, 3};
  f.residual.entries = {ClassResidual::packed(1, 0.5f), ClassResidual::packed(0, -1),
                        ClassResidual::packed(2, 1)};
  return f;
}

/// Those of a dense teacher.
FeatureModel embeddingsFor(const GaussianField& field) {
  FeatureModel f = featuresFor(field);
  f.codes.clear();
  f.scale = {};
  f.residual = {};
  EmbeddingDecoder& decoder = f.decoder.emplace();
  decoder.size = 5;
  for (std::size_t n = 0; n < decoder.layers()[1].end(); ++n)
    decoder.parameters.push_back(std::cos(static_cast<float>(n)) / 7);
  for (std::size_t n = 0; n < 3 * 5; ++n)
    f.embeddings.push_back(std::sin(2.f + static_cast<float>(n)) / 3);
  return f;
}

Model fieldOf(int count) {
  Model model;
  model.field = randomField(count, true);
  return model;
}

TEST(ModelFeatures, RoundTripIsExact) {
  const TemporaryFolder folder;
  const Model model = fieldOf(21);
  for (const int channels : {8, 16, 32}) {
    const FeatureModel written = featuresFor(model.field, channels);
    writeModel(model, folder / "a.innergs", {}, &written);
    std::optional<FeatureModel> read;
    EXPECT_TRUE(
        sameBits(readModel(folder / "a.innergs", nullptr, &read).field.gaussians, model.field.gaussians));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->channels, channels);
    EXPECT_EQ(read->latents, written.latents);
    EXPECT_EQ(read->codes, written.codes);
    EXPECT_EQ(read->names, written.names);
    EXPECT_EQ(read->labels, written.labels);
    EXPECT_EQ(read->scale.low, written.scale.low);
    EXPECT_EQ(read->scale.knots, written.scale.knots);
    EXPECT_EQ(read->support.blocks, written.support.blocks);
    EXPECT_EQ(read->support.bits, written.support.bits);
    EXPECT_EQ(read->residual.grid, written.residual.grid);
    EXPECT_EQ(read->residual.voxels, written.residual.voxels);
    EXPECT_EQ(read->residual.ends, written.residual.ends);
    EXPECT_EQ(read->residual.entries, written.residual.entries);
    const GridGeometry grid = cropped(model.field.domain, {10, 10, 10}, {6, 5, 4});
    EXPECT_EQ(classify(model.field, *read, grid).classes, classify(model.field, written, grid).classes);
  }
}

TEST(ModelFeatures, ThoseOfADenseTeacherReadBackExactly) {
  const TemporaryFolder folder;
  const Model model = fieldOf(21);
  const FeatureModel written = embeddingsFor(model.field);
  writeModel(model, folder / "a.innergs", {}, &written);
  std::optional<FeatureModel> read;
  readModel(folder / "a.innergs", nullptr, &read);
  ASSERT_TRUE(read && read->decoder);
  EXPECT_EQ(read->decoder->size, 5);
  EXPECT_EQ(read->decoder->channels, 16);
  EXPECT_EQ(read->decoder->parameters, written.decoder->parameters);
  EXPECT_EQ(read->embeddings, written.embeddings);
  EXPECT_TRUE(read->codes.empty());
  const GridGeometry grid = cropped(model.field.domain, {10, 10, 10}, {6, 5, 4});
  EXPECT_EQ(classify(model.field, *read, grid).classes, classify(model.field, written, grid).classes);
  FeatureModel broken = written;
  broken.embeddings.pop_back();
  EXPECT_EQ(errorOf([&] { writeModel(model, folder / "b.innergs", {}, &broken); }).code(),
            ErrorCode::FileFormat);
  broken = written;
  broken.decoder->parameters.pop_back();
  EXPECT_EQ(errorOf([&] { writeModel(model, folder / "b.innergs", {}, &broken); }).code(),
            ErrorCode::FileFormat);
}

TEST(ModelFeatures, AModelWithoutThemStaysAsItWas) {
  const TemporaryFolder folder;
  writeModel(fieldOf(9), folder / "a.innergs");
  EXPECT_EQ(readBytes(folder / "a.innergs").find("feature"), std::string::npos);
  std::optional<FeatureModel> read = FeatureModel{};
  readModel(folder / "a.innergs", nullptr, &read);
  EXPECT_FALSE(read);
}

TEST(ModelFeatures, WhatDoesNotFitIsRefused) {
  const TemporaryFolder folder;
  const Model model = fieldOf(9);
  FeatureModel features = featuresFor(model.field);
  writeModel(model, folder / "a.innergs", {}, &features);
  const std::string bytes = readBytes(folder / "a.innergs");
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string forged = bytes;
    const auto at = forged.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    writeBytes(folder / "b.innergs", forged.replace(at, from.size(), to));
    std::optional<FeatureModel> read;
    EXPECT_EQ(errorOf([&] { readModel(folder / "b.innergs", nullptr, &read); }).code(), ErrorCode::FileFormat)
        << to;
  };
  refused("feature_codes", "feature_cedes");
  refused("feature_residual_ends", "feature_residual_ands");
  refused("[0,5,65535]", "[0,5,65536]");
  refused("\\\"size\\\":[3,4,5]", "\\\"size\\\":[3,4,9]");
  features.latents.pop_back();
  EXPECT_EQ(errorOf([&] { writeModel(model, folder / "c.innergs", {}, &features); }).code(),
            ErrorCode::FileFormat);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.innergs"));
}

} // namespace
} // namespace innergs::test
