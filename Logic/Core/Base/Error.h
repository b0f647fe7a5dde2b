#pragma once
#include <stdexcept>
#include <string>

namespace innergs {

enum class ErrorCode {
  InvalidArgument, // a setting or option out of range
  FileNotFound,
  FileFormat,       // not an image or model, truncated, forged
  UnsupportedImage, // RGB, complex, vector, 4D, a single slice
  Geometry,         // spacing, direction, stacks that do not overlap
  NoData,           // empty image or mask, no finite voxel
  Memory,           // more needed than is available
  Io,               // cannot write, disk full
  Cancelled,
  Internal
};

/// The one exception type of InnerGS. what() is one sentence: what is wrong and what to do.
class Error : public std::runtime_error {
public:
  Error(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

private:
  ErrorCode code_;
};

} // namespace innergs
