#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace innergs {

/// What ITK's NRRD and MetaImage readers hide, silently repair or reject with text of their own. Both
/// constructors throw Error(Geometry) for spacings, directions or origins that are zero, negative or not
/// finite, and Error(FileFormat) when a required field is missing.
struct NrrdHeader {
  NrrdHeader(const std::filesystem::path& path, const std::string& what);
  bool sequence = false;            // one axis is a list of frames (3D Slicer's .seq.nrrd)
  std::string indexName, indexUnit; // of that axis; empty: not given
  std::vector<double> indexValues;  // one per frame; empty: not given, or not all are numbers
};

class MetaHeader {
public:
  MetaHeader(const std::filesystem::path& path, const std::string& what);
  /// False when the voxels in the same or one other file are surely fewer than `bytes`: MetaIO then returns
  /// what there is.
  bool holds(std::uint64_t bytes) const;
  bool tracked = false; // each slice has a transform of its own (PLUS sequence files)

private:
  std::filesystem::path voxelFile_; // empty: several files
  std::uint64_t voxelsStart_ = 0;
  bool binary_ = true, compressed_ = false;
};

} // namespace innergs
