#pragma once
#include <new>
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
  Memory,           // more needed than available
  Io,               // cannot write, disk full
  Cancelled,
  Internal
};

/// The one exception of InnerGS. what() is one sentence that says what is wrong and what to do.
class Error : public std::runtime_error {
public:
  Error(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

private:
  ErrorCode code_;
};

/// What to tell the user of whatever was thrown.
inline std::string sentenceOf(const std::exception& error) {
  if (dynamic_cast<const Error*>(&error)) return error.what();
  if (dynamic_cast<const std::bad_alloc*>(&error))
    return "The memory is not enough: choose a smaller region, a coarser output or fewer Gaussians.";
  return std::string("Unexpected failure (") + error.what() +
         "): please report it with these data and settings.";
}

} // namespace innergs
