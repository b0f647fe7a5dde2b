#include "IO/Safetensors.h"

#include "Core/Base/Error.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <fstream>
#include <utility>

namespace innergs {
namespace {

static_assert(std::endian::native == std::endian::little, "safetensors files are little-endian");

using nlohmann::json;
constexpr std::uint64_t largestHeader = 100'000'000; // the safetensors library's limit

std::int64_t elements(const std::vector<std::int64_t>& shape) {
  std::int64_t count = 1;
  for (const std::int64_t n : shape)
    count *= n;
  return count;
}

/// 0 for a dtype that the format does not define.
std::uint64_t bytesOf(const std::string& dtype) {
  static const std::map<std::string, std::uint64_t> table{
      {"BOOL", 1}, {"U8", 1},  {"I8", 1},  {"F8_E4M3", 1}, {"F8_E5M2", 1}, {"U16", 2}, {"I16", 2}, {"F16", 2},
      {"BF16", 2}, {"U32", 4}, {"I32", 4}, {"F32", 4},     {"U64", 8},     {"I64", 8}, {"F64", 8}};
  const auto found = table.find(dtype);
  return found == table.end() ? 0 : found->second;
}

bool readUnsigned(const json& value, std::uint64_t& out) {
  if (!value.is_number_unsigned()) return false;
  out = value.get<std::uint64_t>();
  return true;
}

/// False if anything is missing, of the wrong type, out of range or inconsistent.
bool readTensor(const json& entry, std::uint64_t dataBytes, SafetensorsFile::Tensor& tensor) {
  if (!entry.is_object() || !entry.contains("dtype") || !entry.contains("shape") ||
      !entry.contains("data_offsets"))
    return false;
  const json &dtype = entry["dtype"], &shape = entry["shape"], &offsets = entry["data_offsets"];
  if (!dtype.is_string() || !shape.is_array() || shape.size() > 8 || !offsets.is_array() ||
      offsets.size() != 2)
    return false;
  tensor.dtype = dtype.get<std::string>();
  std::uint64_t bytes = bytesOf(tensor.dtype);
  if (bytes == 0) return false;
  bool empty = false;
  for (const json& length : shape) {
    std::uint64_t n = 0;
    if (!readUnsigned(length, n) || n > (std::uint64_t{1} << 62)) return false;
    tensor.shape.push_back(static_cast<std::int64_t>(n));
    empty = empty || n == 0;
  }
  if (empty)
    bytes = 0;
  else
    for (const std::int64_t n : tensor.shape) {
      if (static_cast<std::uint64_t>(n) > dataBytes / bytes) return false;
      bytes *= static_cast<std::uint64_t>(n);
    }
  return readUnsigned(offsets[0], tensor.begin) && readUnsigned(offsets[1], tensor.end) &&
         tensor.begin <= tensor.end && tensor.end <= dataBytes && tensor.end - tensor.begin == bytes;
}

} // namespace

void writeSafetensors(const std::filesystem::path& path, const std::map<std::string, std::string>& metadata,
                      const std::vector<TensorToWrite>& tensors) {
  json header = {{"__metadata__", metadata}};
  std::uint64_t end = 0;
  for (const TensorToWrite& tensor : tensors) {
    const std::uint64_t begin = end;
    end += static_cast<std::uint64_t>(elements(tensor.shape)) * 4;
    const char* dtype = tensor.values.index() == 0 ? "F32" : "U32";
    header[tensor.name] = {{"dtype", dtype}, {"shape", tensor.shape}, {"data_offsets", {begin, end}}};
  }
  std::string text = header.dump(-1, ' ', false, json::error_handler_t::replace);
  text.append((8 - text.size() % 8) % 8, ' ');

  writeAtomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    const std::uint64_t length = text.size();
    out.write(reinterpret_cast<const char*>(&length), sizeof(length));
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    for (const TensorToWrite& tensor : tensors)
      std::visit(
          [&](const auto& make) {
            const auto values = make();
            out.write(reinterpret_cast<const char*>(values.data()),
                      static_cast<std::streamsize>(values.size() * sizeof(values[0])));
          },
          tensor.values);
    out.close();
    if (!out)
      throw Error(ErrorCode::Io, quoted(path) +
                                     " could not be written (the disk is full or failed); free some space or "
                                     "choose another folder.");
  });
}

SafetensorsFile::SafetensorsFile(const std::filesystem::path& path) : path_(path) {
  const std::uint64_t fileBytes = checkInputFile(path);
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::FileFormat, quoted(path) + " is not an InnerGS model or is damaged (" + why +
                                           "); save or copy it again.");
  };
  std::ifstream in(path, std::ios::binary);
  std::uint64_t length = 0;
  in.read(reinterpret_cast<char*>(&length), sizeof(length));
  if (!in || length < 2 || length > largestHeader || length > fileBytes - sizeof(length))
    fail("its header length is wrong");
  std::string text(static_cast<std::size_t>(length), '\0');
  in.read(text.data(), static_cast<std::streamsize>(length));
  if (!in || text.front() != '{') fail("its header is cut off");
  const json header = json::parse(text, nullptr, false);
  if (!header.is_object()) fail("its header is not JSON");

  dataStart_ = sizeof(length) + length;
  const std::uint64_t dataBytes = fileBytes - dataStart_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  for (const auto& [name, entry] : header.items()) {
    if (name == "__metadata__") {
      if (!entry.is_object()) fail("its metadata is not an object");
      for (const auto& [key, value] : entry.items()) {
        if (!value.is_string()) fail("its metadata is not text");
        metadata_[key] = value.get<std::string>();
      }
      continue;
    }
    Tensor tensor;
    if (!readTensor(entry, dataBytes, tensor)) fail("a tensor does not fit the file");
    ranges.emplace_back(tensor.begin, tensor.end);
    tensors_.emplace(name, std::move(tensor));
  }
  std::sort(ranges.begin(), ranges.end());
  std::uint64_t reached = 0;
  for (const auto& [begin, end] : ranges) {
    if (begin != reached) fail("its tensors overlap or leave gaps");
    reached = end;
  }
  if (reached != dataBytes) fail("its length does not match its tensors");
}

const SafetensorsFile::Tensor* SafetensorsFile::find(const std::string& name) const {
  const auto found = tensors_.find(name);
  return found == tensors_.end() ? nullptr : &found->second;
}

template <class Value>
std::vector<Value> SafetensorsFile::readAs(const char* dtype, const std::string& name,
                                           const std::vector<std::int64_t>& shape) const {
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::FileFormat, quoted(path_) +
                                           " is not an InnerGS model or is damaged (the tensor '" + name +
                                           "' " + why + "); save or copy it again.");
  };
  const Tensor* tensor = find(name);
  if (tensor == nullptr) fail("is missing");
  if (tensor->dtype != dtype || tensor->shape != shape) fail("has another type or shape than expected");
  std::vector<Value> values(static_cast<std::size_t>(elements(shape)));
  std::ifstream in(path_, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(dataStart_ + tensor->begin));
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(values.size() * sizeof(Value)));
  if (!in) fail("is cut off");
  return values;
}

std::vector<float> SafetensorsFile::read(const std::string& name,
                                         const std::vector<std::int64_t>& shape) const {
  return readAs<float>("F32", name, shape);
}

std::vector<std::uint32_t> SafetensorsFile::readUnsigned(const std::string& name,
                                                         const std::vector<std::int64_t>& shape) const {
  return readAs<std::uint32_t>("U32", name, shape);
}

} // namespace innergs
