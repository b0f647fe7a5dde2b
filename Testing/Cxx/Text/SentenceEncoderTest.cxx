#include "Text/SentenceEncoder.h"
#include "Onnx/TestNetworks.h"
#include "ThrownError.h"

#include <cmath>
#include <fstream>

namespace innergs {
namespace {

using testing::NetworkWriter;
using testing::TestFolder;

/// A table with a vector per piece: "liver" and "gland" alike, "bicycle" at right angles.
void writeEncoder(const TestFolder& folder, bool withTypes = true) {
  std::ofstream vocabulary(folder / "vocab.txt", std::ios::binary);
  for (const char* piece : {"[PAD]", "[UNK]", "[CLS]", "[SEP]", "liver", "gland", "bicycle"})
    vocabulary << piece << "\n";
  NetworkWriter network;
  network.input("input_ids", NetworkWriter::Int64, {-1, -1});
  network.input("attention_mask", NetworkWriter::Int64, {-1, -1});
  if (withTypes) network.input("token_type_ids", NetworkWriter::Int64, {-1, -1});
  network.constant("table", {7, 2}, {9, 9, 0, 0, 0, 0, 0, 0, 3, 0, 3, 1, 0, 5});
  network.node("Gather", {"table", "input_ids"}, "last_hidden_state");
  network.output("last_hidden_state", {-1, -1, 2});
  network.write(folder / "model.onnx");
}

TEST(SentenceEncoder, MeanOfThePiecesAtUnitLength) {
  INNERGS_NEEDS_OPENVINO();
  for (const bool withTypes : {true, false}) {
    const TestFolder folder;
    writeEncoder(folder, withTypes);
    SentenceEncoder encoder(folder.path());
    // Padding of the shorter texts, which the table gives (9, 9), does not count.
    const auto all = encoder.encode({"liver", "Liver gland, bicycle", "bicycle"});
    ASSERT_EQ(all.size(), 3u);
    EXPECT_NEAR(all[0][0], 1, 1e-6);
    EXPECT_NEAR(all[0][1], 0, 1e-6);
    EXPECT_NEAR(all[1][0], 6 / std::sqrt(72.0), 1e-6); // sum (6, 6)
    EXPECT_NEAR(all[2][1], 1, 1e-6);
    EXPECT_TRUE(encoder.encode({}).empty());
    EXPECT_EQ(encoder.encode(std::vector<std::string>(70, "gland")).size(), 70u);
  }
}

TEST(SentenceEncoder, SaysWhatIsMissingWhere) {
  const TestFolder folder;
  const auto sentenceOf = [&](const std::filesystem::path& path) {
    setSentenceFolder(path);
    const SentenceModel model = sentenceModel();
    setSentenceFolder({});
    EXPECT_EQ(model.embedding, nullptr);
    return model.problem;
  };
  EXPECT_NE(sentenceOf(folder / "nowhere").find("There is no folder"), std::string::npos);
  EXPECT_NE(sentenceOf(folder.path()).find("model.onnx"), std::string::npos);
  std::ofstream(folder / "model.onnx") << "no network";
  EXPECT_NE(sentenceOf(folder.path()).find("vocab.txt"), std::string::npos);
}

TEST(SentenceEncoder, ForeignNetworkIsOneSentence) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  writeEncoder(folder);
  testing::writePointwise(folder / "model.onnx", 2, 8, {1}, {0});
  EXPECT_TRUE(test::contains(test::errorOf([&] { SentenceEncoder encoder(folder.path()); }), "input_ids"));
}

TEST(SentenceEncoder, IsLoadedOnceForAFolder) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  writeEncoder(folder);
  setSentenceFolder(folder.path());
  const SentenceModel first = sentenceModel(), second = sentenceModel();
  setSentenceFolder({});
  EXPECT_NE(first.embedding, nullptr) << first.problem;
  EXPECT_EQ(first.embedding, second.embedding);
}

} // namespace
} // namespace innergs
