#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace innergs {

/// Header fields that ITK's NRRD and MetaImage readers hide, silently repair or reject with messages of their
/// own. Both constructors throw Error(Geometry) for spacings, directions or origins that are zero, negative
/// or not finite, and Error(FileFormat) if a required field is missing.
struct NrrdHeader {
  NrrdHeader(const std::filesystem::path& path, const std::string& what);
  bool sequence = false;             // one axis is a list of frames (3D Slicer's .seq.nrrd)
  std::string indexName, indexUnit;  // of that axis; empty if absent
  std::vector<double> indexValues;   // one per frame; empty if absent or not all numeric
  std::array<double, 3> thickness{}; // of slices along each axis of space, mm; 0: not said
};

class MetaHeader {
public:
  MetaHeader(const std::filesystem::path& path, const std::string& what);
  /// False if the voxels, in this file or one other, are certainly fewer than `bytes`; MetaIO would silently
  /// return what there is.
  bool holds(std::uint64_t bytes) const;
  bool tracked = false; // each slice has its own transform (PLUS sequence files)
  /// Of slices along each axis, mm, where voxels are larger or smaller (ElementSize) than they lie apart
  /// (ElementSpacing) along that axis alone; 0: not said.
  std::array<double, 3> thickness{};
  std::map<std::string, std::string> fields; // of a tracked sweep; empty otherwise

private:
  std::filesystem::path voxelFile_; // empty: several files
  std::uint64_t voxelsStart_ = 0;
  bool binary_ = true, compressed_ = false;
};

} // namespace innergs
