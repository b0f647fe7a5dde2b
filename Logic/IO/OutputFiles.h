#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace innergs {

/// The files that a run writes. They are checked before the start, also against its inputs, and each is
/// attempted at the end, so that one failure does not affect the others.
class OutputFiles {
public:
  enum class Kind { Any, Volume, Model, Ply, Png };

  /// Protects a file, or a folder with its files, from being overwritten; includes voxel files named by a
  /// header.
  void read(const std::filesystem::path& input);
  /// Throws Error(InvalidArgument | Io) if the file could not be written: wrong kind of extension, folder
  /// missing or not writable, name too long, same file as an input or as another output. Ignores "".
  void add(const std::filesystem::path& output, Kind kind = Kind::Any);

  /// Calls `write` with the path and stores what it throws for check(). Returns false if it threw, and for
  /// "".
  bool write(const std::filesystem::path& output,
             const std::function<void(const std::filesystem::path&)>& write);
  /// "a.nii.gz, b.innergs"
  std::string written() const;
  /// One sentence per failure; empty if there was none.
  const std::vector<std::string>& failures() const { return failures_; }
  /// Throws Error(Io) with all failures and a list of what was written.
  void check() const;

private:
  std::vector<std::filesystem::path> inputs_, outputs_, written_;
  std::vector<std::string> failures_;
};

} // namespace innergs
