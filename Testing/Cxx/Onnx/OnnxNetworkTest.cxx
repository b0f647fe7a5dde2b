#include "Onnx/OnnxNetwork.h"
#include "../Core/ThrownError.h"
#include "TestNetworks.h"

#include <fstream>

namespace innergs {
namespace {

using testing::NetworkWriter;
using testing::TestFolder;

TEST(OpenVino, SaysWhatIsMissing) {
  const OpenVino found = openVino();
  EXPECT_EQ(found.functions == nullptr, !found.problem.empty());
  EXPECT_EQ(found.functions != nullptr, !found.version.empty());
}

TEST(OnnxNetwork, MissingFileIsOneSentence) {
  EXPECT_EQ(test::codeOf([] { OnnxNetwork("nowhere.onnx"); }), ErrorCode::FileNotFound);
}

TEST(OnnxNetwork, KnowsItsPortsAndRuns) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  NetworkWriter writer;
  writer.input("ids", NetworkWriter::Int64, {-1, 3});
  writer.nodeWith("Cast", {"ids"}, "numbers", "to", NetworkWriter::Float);
  writer.constant("half", {1}, {0.5f});
  writer.node("Mul", {"numbers", "half"}, "halves");
  writer.output("halves", {-1, 3});
  writer.write(folder / "halves.onnx");
  const OnnxNetwork network(folder / "halves.onnx", 2);
  ASSERT_EQ(network.inputs().size(), 1u);
  EXPECT_EQ(network.inputs()[0].name, "ids");
  EXPECT_EQ(network.inputs()[0].type, NetworkPort::Type::Integer);
  EXPECT_EQ(network.inputs()[0].shape, (std::vector<std::int64_t>{-1, 3}));
  EXPECT_EQ(network.streams(), 2);
  const NetworkTensor out = network.run({{{2, 3}, std::vector<std::int64_t>{1, 2, 3, 4, 5, 6}}}, 0, 1);
  EXPECT_EQ(out.shape, (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ(std::get<std::vector<float>>(out.values), (std::vector<float>{0.5f, 1, 1.5f, 2, 2.5f, 3}));
  const std::vector<NetworkTensor> narrow{{{2, 2}, std::vector<std::int64_t>{1, 2, 3, 4}}},
      incomplete{{{2, 3}, std::vector<std::int64_t>{1}}};
  EXPECT_EQ(test::codeOf([&] { network.run(narrow); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(test::codeOf([&] { network.run(incomplete); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(test::codeOf([&] { network.run({}); }), ErrorCode::InvalidArgument);
}

TEST(OnnxNetwork, ForeignFileIsOneSentence) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  std::ofstream(folder / "foreign.onnx") << "no network";
  EXPECT_EQ(test::codeOf([&] { OnnxNetwork(folder / "foreign.onnx"); }), ErrorCode::FileFormat);
  NetworkWriter unknown;
  unknown.input("x", NetworkWriter::Float, {1});
  unknown.node("NoSuchOperation", {"x"}, "y");
  unknown.output("y", {1});
  unknown.write(folder / "unknown.onnx");
  EXPECT_EQ(test::codeOf([&] { OnnxNetwork(folder / "unknown.onnx"); }), ErrorCode::FileFormat);
}

} // namespace
} // namespace innergs
