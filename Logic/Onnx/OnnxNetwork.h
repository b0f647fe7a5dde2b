#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace innergs {

/// An input or output of a network.
struct NetworkPort {
  enum class Type { Float, Integer, Other };
  std::string name;
  Type type = Type::Other;
  bool anyRank = false;            // its number of axes is open
  std::vector<std::int64_t> shape; // sizes, the first axis slowest; −1: open
};

struct NetworkTensor {
  std::vector<std::int64_t> shape;
  std::variant<std::vector<float>, std::vector<std::int64_t>> values;
};

/// A network in an ONNX file, run by OpenVINO on the CPU in single precision. Each stream computes on a
/// thread of its own, so that results do not depend on the number of streams.
class OnnxNetwork {
public:
  /// Throws Error(FileNotFound), Error(FileFormat) if it is not a network, Error(NoData) without OpenVINO.
  explicit OnnxNetwork(const std::filesystem::path& file, int streams = 1);
  ~OnnxNetwork();
  OnnxNetwork(OnnxNetwork&&) noexcept;

  const std::vector<NetworkPort>& inputs() const;
  const std::vector<NetworkPort>& outputs() const;
  int streams() const;
  /// 'file', for messages.
  const std::string& name() const;

  /// An output, as floats, of tensors in the order of the inputs. One thread per stream. Throws
  /// Error(InvalidArgument) for tensors that the network does not take, Error(UnsupportedImage) for an output
  /// of another type.
  NetworkTensor run(const std::vector<NetworkTensor>& inputs, std::size_t output = 0, int stream = 0) const;

private:
  struct Internals;
  std::unique_ptr<Internals> work_;
};

} // namespace innergs
