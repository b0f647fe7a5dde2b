#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace innergs {

/// A float32 or unsigned 32-bit tensor to write, with values generated on demand.
struct TensorToWrite {
  std::string name;
  std::vector<std::int64_t> shape;
  std::variant<std::function<std::vector<float>()>, std::function<std::vector<std::uint32_t>()>> values;
};

/// Writes a safetensors file atomically. Throws Error(Io).
void writeSafetensors(const std::filesystem::path& path, const std::map<std::string, std::string>& metadata,
                      const std::vector<TensorToWrite>& tensors);

/// A safetensors file with a checked header: all tensors lie within the file, do not overlap and cover all of
/// it.
class SafetensorsFile {
public:
  struct Tensor {
    std::string dtype;
    std::vector<std::int64_t> shape;
    std::uint64_t begin = 0, end = 0; // bytes, from the start of the data
  };

  /// Throws Error(FileNotFound | FileFormat).
  explicit SafetensorsFile(const std::filesystem::path& path);

  const std::map<std::string, std::string>& metadata() const { return metadata_; }
  /// nullptr if absent.
  const Tensor* find(const std::string& name) const;
  ///@{
  /// The values of a tensor. Throws Error(FileFormat) if it is absent or has another type or shape.
  std::vector<float> read(const std::string& name, const std::vector<std::int64_t>& shape) const;
  std::vector<std::uint32_t> readUnsigned(const std::string& name,
                                          const std::vector<std::int64_t>& shape) const;
  ///@}

private:
  template <class Value>
  std::vector<Value> readAs(const char* dtype, const std::string& name,
                            const std::vector<std::int64_t>& shape) const;

  std::filesystem::path path_;
  std::uint64_t dataStart_ = 0;
  std::map<std::string, std::string> metadata_;
  std::map<std::string, Tensor> tensors_;
};

} // namespace innergs
