#pragma once
#include "Core/Image/GridGeometry.h"
#include "IO/OutputType.h"

#include <filesystem>
#include <map>
#include <string>

namespace innergs {

/// Voxels as stored in a file: rounded if its type is an integer.
class TypedVoxels {
public:
  /// `voxels` must outlive it. Throws like checkType; `path` names the file in messages.
  TypedVoxels(std::span<const float> voxels, OutputType type, const std::optional<VoxelValues>& expected,
              const std::filesystem::path& path);

  const void* data() const {
    return integers_.empty() ? static_cast<const void*>(voxels_.data()) : integers_.data();
  }
  std::uint64_t bytes() const { return integers_.empty() ? voxels_.size_bytes() : integers_.size(); }
  /// A sentence if values were clipped, else "".
  const std::string& remark() const { return remark_; }

private:
  std::span<const float> voxels_;
  std::vector<std::byte> integers_;
  std::string remark_;
};

/// Whether the name is that of a 3D Slicer sequence: "name.seq.nrrd".
bool isSequenceFile(const std::filesystem::path& path);
/// The message for a full disk.
std::string writingFailed(const std::filesystem::path& path);

/// Writes a header and the voxels after it, compressed by zlib or not as `mode` (gzopen's) says. Throws
/// Error(Io, failed).
void writeBehind(const std::string& header, const void* voxels, std::uint64_t bytes, const char* mode,
                 const std::filesystem::path& path, const std::string& failed);
/// "(x,y,z)", with all digits.
std::string nrrdVector(const Vec3& v);

/// Throws Error(InvalidArgument) for an extension that writeItkFile() does not know.
void checkVoxelFormat(const std::filesystem::path& path);

/// Writes NIfTI, NRRD or MetaImage by ITK, atomically. fields: further entries of the header; components:
/// values per voxel, more than one as a vector. Throws Error(Io | InvalidArgument).
void writeItkFile(const std::filesystem::path& path, const GridGeometry& geometry, OutputType type,
                  const TypedVoxels& voxels, const std::map<std::string, std::string>& fields = {},
                  unsigned components = 1);

} // namespace innergs
