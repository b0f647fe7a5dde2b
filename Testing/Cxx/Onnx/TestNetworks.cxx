#include "TestNetworks.h"

#include <cstring>
#include <fstream>
#include <random>

namespace innergs::testing {
namespace {

std::string varint(std::uint64_t value) {
  std::string out;
  for (; value > 127; value >>= 7)
    out += static_cast<char>((value & 127) | 128);
  return out + static_cast<char>(value);
}
std::string number(int field, std::int64_t value) {
  return varint(static_cast<std::uint64_t>(field) << 3) + varint(static_cast<std::uint64_t>(value));
}
std::string bytes(int field, const std::string& content) {
  return varint(static_cast<std::uint64_t>(field) << 3 | 2) + varint(content.size()) + content;
}

/// ValueInfoProto
std::string valueInfo(const std::string& name, int type, const std::vector<std::int64_t>& shape) {
  std::string sizes;
  for (std::size_t n = 0; n < shape.size(); ++n)
    sizes += bytes(1, shape[n] >= 0 ? number(1, shape[n]) : bytes(2, "open" + std::to_string(n)));
  return bytes(1, name) + bytes(2, bytes(1, number(1, type) + bytes(2, sizes)));
}

std::string attributeOf(const std::string& name, const std::vector<std::int64_t>& values, bool list) {
  constexpr int kInt = 2, kInts = 7;
  std::string out = bytes(1, name);
  for (const std::int64_t value : values)
    out += number(list ? 8 : 3, value);
  return bytes(5, out + number(20, list ? kInts : kInt));
}

std::string nodeOf(const std::string& kind, const std::vector<std::string>& inputs, const std::string& output,
                   const std::string& attributes) {
  std::string out;
  for (const std::string& input : inputs)
    out += bytes(1, input);
  return bytes(1, out + bytes(2, output) + bytes(4, kind) + attributes);
}

} // namespace

void NetworkWriter::input(const std::string& name, Type type, const std::vector<std::int64_t>& shape) {
  inputs_ += bytes(11, valueInfo(name, type, shape));
}

void NetworkWriter::output(const std::string& name, const std::vector<std::int64_t>& shape) {
  outputs_ += bytes(12, valueInfo(name, Float, shape));
}

void NetworkWriter::constant(const std::string& name, const std::vector<std::int64_t>& shape,
                             const std::vector<float>& values) {
  std::string tensor;
  for (const std::int64_t size : shape)
    tensor += number(1, size);
  std::string raw(4 * values.size(), '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  constants_ += bytes(5, tensor + number(2, Float) + bytes(8, name) + bytes(9, raw));
}

void NetworkWriter::node(const std::string& kind, const std::vector<std::string>& inputs,
                         const std::string& output,
                         const std::vector<std::pair<std::string, std::vector<std::int64_t>>>& attributes) {
  std::string all;
  for (const auto& [name, values] : attributes)
    all += attributeOf(name, values, true);
  nodes_ += nodeOf(kind, inputs, output, all);
}

void NetworkWriter::nodeWith(const std::string& kind, const std::vector<std::string>& inputs,
                             const std::string& output, const std::string& attribute, std::int64_t value) {
  nodes_ += nodeOf(kind, inputs, output, attributeOf(attribute, {value}, false));
}

void NetworkWriter::write(const std::filesystem::path& path) const {
  const std::string graph = nodes_ + bytes(2, "graph") + constants_ + inputs_ + outputs_;
  std::ofstream out(path, std::ios::binary);
  out << number(1, 8) << bytes(8, number(2, 13)) << bytes(7, graph);
}

TestFolder::TestFolder()
    : path_(std::filesystem::temp_directory_path() /
            ("innergs-network-" + std::to_string(std::random_device{}()))) {
  std::filesystem::create_directories(path_);
}
TestFolder::~TestFolder() {
  std::error_code none;
  std::filesystem::remove_all(path_, none);
}

void writePointwise(const std::filesystem::path& path, int axes, std::int64_t size,
                    const std::vector<float>& a, const std::vector<float>& b) {
  const auto channels = static_cast<std::int64_t>(a.size());
  std::vector<std::int64_t> in{1, 1}, out{1, channels}, kernel{channels, 1};
  for (int n = 0; n < axes; ++n) {
    in.push_back(size);
    out.push_back(size);
    kernel.push_back(1);
  }
  NetworkWriter network;
  network.input("image", NetworkWriter::Float, in);
  network.constant("a", kernel, a);
  network.constant("b", {channels}, b);
  network.node("Conv", {"image", "a", "b"}, "channels");
  network.output("channels", out);
  network.write(path);
}

} // namespace innergs::testing
