#include "Onnx/DenseNetwork.h"
#include "../Core/ThrownError.h"
#include "TestNetworks.h"

#include <cmath>

namespace innergs {
namespace {

using testing::NetworkWriter;
using testing::TestFolder;
using testing::writePointwise;

Volume ramp(std::array<std::int64_t, 3> size) {
  Volume image;
  image.geometry.size = size;
  image.geometry.spacing = {1, 2, 3};
  for (std::int64_t v = 0; v < image.geometry.voxelCount(); ++v)
    image.voxels.push_back(static_cast<float>(std::sin(0.1 * static_cast<double>(v))));
  return image;
}

void expectPointwise(const EmbeddingVolume& maps, const Volume& image) {
  ASSERT_EQ(maps.channels.size(), 2u);
  ASSERT_EQ(maps.geometry, image.geometry);
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    const float scaled = 0.5f * (image.voxels[v] + 1);
    ASSERT_NEAR(maps.channels[0][v], 2 * scaled, 1e-5) << v;
    ASSERT_NEAR(maps.channels[1][v], 1 - scaled, 1e-5) << v;
  }
}

DenseNetworkOptions unitRange() {
  DenseNetworkOptions options;
  options.range = ValueRange{-1, 1};
  return options;
}

TEST(DenseNetwork, WindowsOfAnyFitBlendToTheWholeImage) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  for (const auto& [axes, window] : {std::pair{3, 8}, {3, -1}, {2, 8}, {2, -1}}) {
    writePointwise(folder / "pointwise.onnx", axes, window, {2, -1}, {0, 1});
    for (const auto& size :
         {std::array<std::int64_t, 3>{21, 13, 9}, {5, 8, 3}}) { // one smaller than a window
      const Volume image = ramp(size);
      DenseNetworkOptions options = unitRange();
      options.window = {7, 6, 5};
      expectPointwise(applyNetwork(folder / "pointwise.onnx", image, options), image);
    }
  }
}

TEST(DenseNetwork, ThreadsDoNotChangeABit) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  NetworkWriter network; // each window's own mean: windows that overlap disagree
  network.input("image", NetworkWriter::Float, {1, 1, 4, 8, 8});
  network.node("GlobalAveragePool", {"image"}, "mean");
  network.node("Add", {"image", "mean"}, "both");
  network.output("both", {1, 1, 4, 8, 8});
  network.write(folder / "mean.onnx");
  const Volume image = ramp({21, 13, 9});
  DenseNetworkOptions options;
  options.threads = 1;
  const EmbeddingVolume one = applyNetwork(folder / "mean.onnx", image, options);
  options.threads = 3;
  EXPECT_EQ(applyNetwork(folder / "mean.onnx", image, options).channels, one.channels);
}

TEST(DenseNetwork, CoarseFeaturesAndAnotherSpacing) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  NetworkWriter network;
  network.input("image", NetworkWriter::Float, {1, 1, 4, 8, 8});
  network.node("AveragePool", {"image"}, "coarse", {{"kernel_shape", {2, 2, 2}}, {"strides", {2, 2, 2}}});
  network.output("coarse", {1, 1, 2, 4, 4});
  network.write(folder / "coarse.onnx");
  Volume image = ramp({16, 8, 8});
  std::fill(image.voxels.begin(), image.voxels.end(), 0.25f);
  DenseNetworkOptions options;
  options.range = ValueRange{0, 1};
  options.spacing = 2;
  const EmbeddingVolume maps = applyNetwork(folder / "coarse.onnx", image, options);
  EXPECT_TRUE(sameGrid(maps.geometry, withSpacing(image.geometry, {2, 2, 2})));
  for (const float value : maps.channels.at(0))
    ASSERT_NEAR(value, 0.25f, 1e-6);
}

TEST(DenseNetwork, ChannelsBecomeLabels) {
  EmbeddingVolume maps;
  maps.geometry.size = {3, 1, 1};
  maps.channels = {{0.5f, 0.1f, 0.2f}, {0.4f, 0.8f, 0.2f}, {0.1f, 0.1f, 0.6f}};
  EXPECT_EQ(likeliestChannel(maps).voxels, (std::vector<std::uint16_t>{0, 1, 2}));
  maps.channels.resize(1);
  EXPECT_THROW(likeliestChannel(maps), Error);
}

TEST(DenseNetwork, RefusesNetworksOfAnotherKind) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  const auto refused = [&](const std::string& why) {
    const Error error = test::errorOf([&] { applyNetwork(folder / "other.onnx", ramp({8, 8, 8})); });
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument) << why;
    EXPECT_TRUE(test::contains(error, why)) << error.what();
  };
  NetworkWriter two;
  two.input("a", NetworkWriter::Float, {1, 1, 8, 8});
  two.input("b", NetworkWriter::Float, {1, 1, 8, 8});
  two.node("Add", {"a", "b"}, "sum");
  two.output("sum", {1, 1, 8, 8});
  two.write(folder / "other.onnx");
  refused("2 inputs");
  NetworkWriter vector;
  vector.input("a", NetworkWriter::Float, {1, 8});
  vector.node("Relu", {"a"}, "b");
  vector.output("b", {1, 8});
  vector.write(folder / "other.onnx");
  refused("2 axes");
  NetworkWriter classifier;
  classifier.input("image", NetworkWriter::Float, {1, 1, 8, 8});
  classifier.nodeWith("Flatten", {"image"}, "flat", "axis", 1);
  classifier.output("flat", {1, 64});
  classifier.write(folder / "other.onnx");
  refused("an output of 2 axes");
}

TEST(DenseNetwork, StopsBetweenWindows) {
  INNERGS_NEEDS_OPENVINO();
  const TestFolder folder;
  writePointwise(folder / "pointwise.onnx", 3, 4, {1}, {0});
  std::stop_source stop;
  DenseNetworkOptions options;
  options.stop = stop.get_token();
  options.progress = [&](double) { stop.request_stop(); };
  const Volume image = ramp({32, 8, 8});
  EXPECT_EQ(test::codeOf([&] { applyNetwork(folder / "pointwise.onnx", image, options); }),
            ErrorCode::Cancelled);
}

} // namespace
} // namespace innergs
