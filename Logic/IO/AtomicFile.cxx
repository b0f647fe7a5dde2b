#include "IO/AtomicFile.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "IO/FileReplacement.h"

#include <fstream>
#include <random>

namespace fs = std::filesystem;

namespace innergs {
namespace {

/// Resolves links, so that a link then points at the new file instead of being replaced by it.
fs::path fileOf(const fs::path& path) {
  std::error_code failed;
  if (!fs::is_symlink(path, failed)) return path;
  fs::path file = followed(path);
  if (fs::is_symlink(file, failed))
    throw Error(ErrorCode::Io, quoted(path) + " is a link that leads nowhere; choose another name.");
  return file;
}

/// A name in the same folder that no other process or thread uses; keeps the extension, which writers depend
/// on.
fs::path temporaryBeside(const fs::path& target, const std::string& extension) {
  std::random_device random;
  constexpr char digits[] = "0123456789abcdef";
  std::string name = ".innergs-";
  for (int i = 0; i < 16; ++i)
    name += digits[random() % 16];
  return target.parent_path() / (name + extension);
}

/// Removes the temporary file unless it has been renamed.
struct TemporaryFile {
  fs::path path;
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
};

Error cannotWrite(const fs::path& target, const std::string& why) {
  return {ErrorCode::Io, quoted(target) + " could not be written (" + why +
                             "); free some space, check the permissions or choose another folder."};
}

void writeBytes(const fs::path& path, std::string_view bytes, const fs::path& target) {
  std::ofstream out(path, std::ios::binary);
  if (!out) throw cannotWrite(target, "the file cannot be created");
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw cannotWrite(target, "the disk is full or failed");
}

bool isDevice(const fs::path& target) {
  std::error_code ignored;
  return fs::exists(target, ignored) && !fs::is_regular_file(target, ignored) &&
         !fs::is_directory(target, ignored);
}

} // namespace

void writeAtomically(const fs::path& target, const std::function<void(const fs::path&)>& write) {
  checkOutputFolder(target);
  if (isDevice(target))
    throw Error(ErrorCode::Io, quoted(target) + " is not a regular file; choose another name.");
  const fs::path file = fileOf(target);
  const TemporaryFile temporary{temporaryBeside(file, fullExtension(target))};
  if (const std::error_code failed = createReplacement(temporary.path, file))
    throw cannotWrite(target, failed.message());
  write(temporary.path);
  std::error_code failed;
  if (fs::file_size(temporary.path, failed) == 0 || failed) throw cannotWrite(target, "nothing was written");
  failed = replaceFile(temporary.path, file);
  if (failed) throw cannotWrite(target, failed.message());
}

void writeFileAtomically(const fs::path& target, std::string_view bytes) {
  if (isDevice(target)) return writeBytes(target, bytes, target);
  writeAtomically(target, [&](const fs::path& path) { writeBytes(path, bytes, target); });
}

void checkOutputFolder(const fs::path& path) {
  std::error_code failed;
  if (path.empty() || !path.has_filename())
    throw Error(ErrorCode::InvalidArgument, quoted(path) + " is not a file name; add one.");
  if (fs::is_directory(path, failed))
    throw Error(ErrorCode::Io, quoted(path) + " is a folder; give the name of a file in it.");
  const fs::path file = fileOf(path);
  const TemporaryFile probe{temporaryBeside(file, fullExtension(path))};
  for (const fs::path& name : {path, probe.path}) {
    static_cast<void>(fs::symlink_status(name, failed));
    if (failed == std::errc::filename_too_long)
      throw Error(ErrorCode::Io, quoted(path) + " is too long a name for this disk; choose a shorter one.");
  }
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, failed))
    throw Error(ErrorCode::Io,
                "The folder " + quoted(folder) + " does not exist; create it or choose another.");
  if (isDevice(path)) return;
  if (createReplacement(probe.path, file))
    throw Error(ErrorCode::Io, "No file can be created in the folder " + quoted(folder) +
                                   "; check its permissions or choose another.");
}

} // namespace innergs
