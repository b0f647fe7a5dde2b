#include "IO/VoxelWriting.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/Inflate.h"
#include "IO/ItkImage.h"

#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itk_zlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>

namespace fs = std::filesystem;

namespace innergs {
namespace {

using Component = itk::CommonEnums::IOComponent;

struct OutputFormat {
  itk::ImageIOBase::Pointer io;
  bool compressed;
  std::string headerEnd; // end of the header, before the voxels; empty: the header has 352 bytes (NIfTI)
};

OutputFormat outputFormatOf(const fs::path& path) {
  const std::string extension = fullExtension(path);
  if (extension == ".nii" || extension == ".nii.gz")
    return {itk::NiftiImageIO::New().GetPointer(), extension == ".nii.gz", ""};
  if (extension == ".nrrd") return {itk::NrrdImageIO::New().GetPointer(), true, "\n\n"};
  if (extension == ".mha") return {itk::MetaImageIO::New().GetPointer(), true, "ElementDataFile = LOCAL\n"};
  throw Error(ErrorCode::InvalidArgument,
              quoted(path) + " has no extension of a volume format; use .nii.gz, .nii, .nrrd or .mha.");
}

Component componentOf(OutputType type) {
  constexpr std::array components{Component::FLOAT, Component::UCHAR, Component::SHORT, Component::USHORT,
                                  Component::INT};
  return components.at(static_cast<std::size_t>(type));
}

std::uint64_t voxelsStart(std::ifstream& in, const std::string& headerEnd) {
  if (headerEnd.empty()) return 352;
  std::string head(1 << 16, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  in.clear();
  const std::size_t at = head.find(headerEnd);
  return at == std::string::npos ? head.size() : at + headerEnd.size();
}

/// niftilib and MetaIO do not report a full disk, so this reads the file back and counts.
bool isComplete(const fs::path& path, const OutputFormat& format, std::uint64_t voxelBytes) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return false;
  if (!format.compressed) return fs::file_size(path) >= 352 + voxelBytes;
  if (format.headerEnd.empty()) return inflatedBytes(in, 0) == 352 + voxelBytes;
  return inflatedBytes(in, voxelsStart(in, format.headerEnd)) == voxelBytes;
}

void writeWithItk(const OutputFormat& format, const GridGeometry& geometry, OutputType type,
                  unsigned components, const void* voxels, const fs::path& path) {
  itk::ImageIOBase& io = *format.io;
  io.SetNumberOfDimensions(3);
  itk::ImageIORegion region(3);
  for (unsigned axis = 0; axis < 3; ++axis) {
    io.SetDimensions(axis, static_cast<itk::SizeValueType>(geometry.size[axis]));
    region.SetSize(axis, static_cast<itk::SizeValueType>(geometry.size[axis]));
    io.SetSpacing(axis, geometry.spacing[axis]);
    io.SetOrigin(axis, geometry.origin[axis]);
    const Vec3 direction = column(geometry.direction, static_cast<int>(axis));
    io.SetDirection(axis, std::vector<double>(direction.begin(), direction.end()));
  }
  io.SetPixelType(components == 1 ? itk::CommonEnums::IOPixel::SCALAR : itk::CommonEnums::IOPixel::VECTOR);
  io.SetComponentType(componentOf(type));
  io.SetNumberOfComponents(components);
  io.SetIORegion(region);
  io.SetUseCompression(format.compressed);
  io.SetFileName(utf8(path));
  io.WriteImageInformation();
  io.Write(voxels);
}

} // namespace

void checkVoxelFormat(const fs::path& path) {
  outputFormatOf(path);
}

TypedVoxels::TypedVoxels(std::span<const float> voxels, OutputType type,
                         const std::optional<VoxelValues>& expected, const fs::path& path)
    : voxels_(voxels) {
  if (type == OutputType::Float32) return;
  const VoxelValues values(voxels);
  checkType(type, expected.value_or(values), quoted(path));
  IntegerVoxels rounded(voxels, type);
  integers_ = std::move(rounded.bytes);
  if (rounded.clamped > 0 && !(expected && isOvershoot(type, values, *expected)))
    remark_ = countText(rounded.clamped) + " of " + countText(static_cast<std::int64_t>(voxels.size())) +
              " values of " + quoted(path) + ", which run from " + numberText(values.low) + " to " +
              numberText(values.high) + ", were cut off at the ends of the voxel type's range.";
}

bool isSequenceFile(const fs::path& path) {
  return utf8(path.filename()).ends_with(".seq.nrrd");
}

std::string writingFailed(const fs::path& path) {
  return quoted(path) +
         " could not be written (the disk is full or failed); free some space or choose another folder.";
}

void writeItkFile(const fs::path& path, const GridGeometry& geometry, OutputType type,
                  const TypedVoxels& voxels, const std::map<std::string, std::string>& fields,
                  unsigned components) {
  const OutputFormat format = outputFormatOf(path);
  if (format.headerEnd.empty())
    for (const std::int64_t n : geometry.size)
      if (n > std::numeric_limits<std::int16_t>::max())
        throw Error(ErrorCode::InvalidArgument, "NIfTI holds at most 32767 voxels along an axis; write " +
                                                    quoted(path) + " as .nrrd or .mha.");
  const std::string failed = writingFailed(path);
  for (const auto& [key, value] : fields)
    itk::EncapsulateMetaData<std::string>(format.io->GetMetaDataDictionary(), key, value);
  writeAtomically(path, [&](const fs::path& temporary) {
    withItk(ErrorCode::Io, failed, [&] {
      writeWithItk(format, geometry, type, components, voxels.data(), temporary);
      if (!isComplete(temporary, format, voxels.bytes())) throw Error(ErrorCode::Io, failed);
    });
  });
}

std::string nrrdVector(const Vec3& v) {
  return "(" + exactText(v[0]) + "," + exactText(v[1]) + "," + exactText(v[2]) + ")";
}

void writeBehind(const std::string& header, const void* voxels, std::uint64_t bytes, const char* mode,
                 const fs::path& path, const std::string& failed) {
  gzFile out = gzopen(utf8(path).c_str(), mode);
  bool fine = out != nullptr;
  if (fine && !header.empty()) fine = gzwrite(out, header.data(), static_cast<unsigned>(header.size())) > 0;
  constexpr std::uint64_t chunk = std::uint64_t{1} << 24;
  for (std::uint64_t at = 0; fine && at < bytes; at += chunk) {
    const auto n = static_cast<unsigned>(std::min(chunk, bytes - at));
    fine = gzwrite(out, static_cast<const char*>(voxels) + at, n) == static_cast<int>(n);
  }
  if (out && gzclose(out) != Z_OK) fine = false;
  if (!fine) throw Error(ErrorCode::Io, failed);
}

} // namespace innergs
