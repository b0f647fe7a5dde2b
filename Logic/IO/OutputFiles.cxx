#include "IO/OutputFiles.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/VolumeIO.h"

#include <fstream>

namespace fs = std::filesystem;

namespace innergs {
namespace {

void checkExtension(const fs::path& path, const char* extension, const char* what) {
  if (fullExtension(path) != extension)
    throw Error(ErrorCode::InvalidArgument, quoted(path) + " does not have the extension of " + what +
                                                "; end it with " + extension + ".");
}

/// Whether a header whose voxels are in separate files names this file.
bool namesVoxelFile(const fs::path& header, const fs::path& file) {
  const std::string extension = fullExtension(header);
  if (extension.starts_with(".hdr") || extension.starts_with(".img")) {
    const std::string other = fullExtension(file);
    const auto stem = [](const fs::path& path) {
      const std::string name = utf8(path.filename());
      return name.substr(0, name.size() - fullExtension(path).size());
    };
    return (other.starts_with(".hdr") || other.starts_with(".img")) && stem(header) == stem(file) &&
           isSameFile(header.parent_path() / ".", file.parent_path() / ".");
  }
  if (extension != ".nhdr" && extension != ".mhd") return false;
  std::string text(1 << 16, '\0');
  std::ifstream in(header, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text.find(utf8(file.filename())) != std::string::npos &&
         isSameFile(header.parent_path() / file.filename(), file);
}

bool reads(const fs::path& input, const fs::path& file) {
  std::error_code unknown;
  if (!fs::is_directory(input, unknown)) return isSameFile(input, file) || namesVoxelFile(input, file);
  if (!fs::exists(file, unknown)) return false; // reading a folder means reading its existing files
  for (const fs::directory_entry& entry : fs::directory_iterator(input, unknown))
    if (isSameFile(entry.path(), file)) return true;
  return false;
}

bool isDevice(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(path, unknown) && !fs::is_regular_file(path, unknown);
}

} // namespace

void OutputFiles::read(const fs::path& input) {
  if (!input.empty()) inputs_.push_back(input);
}

void OutputFiles::add(const fs::path& output, Kind kind) {
  if (output.empty()) return;
  if (kind == Kind::Volume)
    checkVolumePath(output);
  else
    checkOutputFolder(output);
  if (kind == Kind::Model) checkExtension(output, ".innergs", "a model");
  if (kind == Kind::Ply) checkExtension(output, ".ply", "a PLY file");
  if (kind == Kind::Png) checkExtension(output, ".png", "a picture");
  if (isDevice(output)) return outputs_.push_back(output);
  for (const fs::path& input : inputs_)
    if (reads(input, output))
      throw Error(ErrorCode::InvalidArgument, quoted(output) + " would overwrite the input " + quoted(input) +
                                                  "; choose another name for the output.");
  for (const fs::path& other : outputs_)
    if (isSameFile(other, output))
      throw Error(ErrorCode::InvalidArgument, quoted(other) + " and " + quoted(output) +
                                                  " are one file; give each output a name of its own.");
  outputs_.push_back(output);
}

bool OutputFiles::write(const fs::path& output, const std::function<void(const fs::path&)>& write) {
  if (output.empty()) return false;
  const std::string failure = sentenceOf([&] { write(output); });
  if (failure.empty())
    written_.push_back(output);
  else
    failures_.push_back(failure);
  return failure.empty();
}

std::string OutputFiles::written() const {
  std::string names;
  for (const fs::path& path : written_)
    names += (names.empty() ? "" : ", ") + utf8(path);
  return names;
}

void OutputFiles::check() const {
  if (failures_.empty()) return;
  std::string sentence;
  for (const std::string& failure : failures_)
    sentence += (sentence.empty() ? "" : " ") + failure;
  if (!written_.empty()) sentence += " Still written: " + written() + ".";
  throw Error(ErrorCode::Io, sentence);
}

} // namespace innergs
