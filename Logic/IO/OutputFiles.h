#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace innergs {

/// The files that a run writes. They are checked before the start, also against what it reads, and each is
/// tried at the end, so that one failure costs none of the others.
class OutputFiles {
public:
  enum class Kind { Any, Volume, Model, Ply, Png };

  /// A file, or a folder with its files, that no output may replace; voxel files beside a header count.
  void read(const std::filesystem::path& input);
  /// Throws Error(InvalidArgument | Io) where the file could not be written: an extension of another kind, a
  /// folder that is missing or not writable, too long a name, what is read, or another output. "" is ignored.
  void add(const std::filesystem::path& output, Kind kind = Kind::Any);

  /// Calls `write` with the path and stores what it throws for check(). False when it threw, and for "".
  bool write(const std::filesystem::path& output,
             const std::function<void(const std::filesystem::path&)>& write);
  /// "a.nii.gz, b.innergs"
  std::string written() const;
  /// One sentence for each failure; empty without one.
  const std::vector<std::string>& failures() const { return failures_; }
  /// Throws Error(Io) with all failures and the list of what was written.
  void check() const;

private:
  std::vector<std::filesystem::path> inputs_, outputs_, written_;
  std::vector<std::string> failures_;
};

} // namespace innergs
