#pragma once
#include "Onnx/OpenVino.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

/// Skips where there is no OpenVINO to run networks.
#define INNERGS_NEEDS_OPENVINO()                                                                             \
  if (!innergs::openVino().functions) GTEST_SKIP() << innergs::openVino().problem

namespace innergs::testing {

/// Writes ONNX files (opset 13): a message of protocol buffers by hand.
class NetworkWriter {
public:
  enum Type { Float = 1, Int64 = 7 };
  /// −1: an open size
  void input(const std::string& name, Type type, const std::vector<std::int64_t>& shape);
  void output(const std::string& name, const std::vector<std::int64_t>& shape);
  void constant(const std::string& name, const std::vector<std::int64_t>& shape,
                const std::vector<float>& values);
  void node(const std::string& kind, const std::vector<std::string>& inputs, const std::string& output,
            const std::vector<std::pair<std::string, std::vector<std::int64_t>>>& attributes = {});
  /// One number, not a list.
  void nodeWith(const std::string& kind, const std::vector<std::string>& inputs, const std::string& output,
                const std::string& attribute, std::int64_t value);
  void write(const std::filesystem::path& path) const;

private:
  std::string nodes_, constants_, inputs_, outputs_;
};

/// A folder of its own, removed at the end.
class TestFolder {
public:
  TestFolder();
  ~TestFolder();
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

/// A network that turns an image into channels a·x + b: a convolution with a kernel of one voxel. axes: 2 or
/// 3; size: of the window along each axis, −1: open.
void writePointwise(const std::filesystem::path& path, int axes, std::int64_t size,
                    const std::vector<float>& a, const std::vector<float>& b);

} // namespace innergs::testing
