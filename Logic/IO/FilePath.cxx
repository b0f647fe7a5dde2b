#include "IO/FilePath.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <fstream>

namespace fs = std::filesystem;

namespace innergs {

fs::path followed(fs::path path) {
  std::error_code failed;
  for (int links = 0; links < 40 && fs::is_symlink(path, failed); ++links) {
    const fs::path next = fs::read_symlink(path, failed);
    if (failed) break;
    path = path.parent_path() / next; // an absolute link target replaces it
  }
  return fs::absolute(path, failed);
}

std::string quoted(const fs::path& path) {
  std::string text(1, '\'');
  text += utf8(path);
  text += '\'';
  return text;
}

std::string fullExtension(const fs::path& path) {
  const auto lower = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
  };
  std::string last = lower(utf8(path.extension()));
  if (last != ".gz") return last;
  return lower(utf8(path.stem().extension())) + last;
}

fs::path withEnding(const fs::path& path, const std::string& ending) {
  std::string name = utf8(path.filename());
  name.resize(name.size() - fullExtension(path).size());
  return path.parent_path() / pathOf(name + ending);
}

bool isSameFile(const fs::path& a, const fs::path& b) {
  std::error_code unknown;
  if (fs::exists(a, unknown) && fs::exists(b, unknown)) return fs::equivalent(a, b, unknown);
  return fs::weakly_canonical(followed(a), unknown) == fs::weakly_canonical(followed(b), unknown);
}

std::uintmax_t checkInputFile(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw Error(ErrorCode::FileNotFound, quoted(path) + " does not exist; check the path.");
  if (!fs::is_regular_file(path, ignored))
    throw Error(ErrorCode::FileFormat, quoted(path) + " is not a file; give the path of a file.");
  if (!std::ifstream(path, std::ios::binary))
    throw Error(ErrorCode::FileNotFound, quoted(path) + " cannot be opened; check its permissions.");
  const std::uintmax_t bytes = fs::file_size(path, ignored);
  if (ignored || bytes == 0)
    throw Error(ErrorCode::FileFormat, quoted(path) + " is empty; copy or export it again.");
  return bytes;
}

} // namespace innergs
