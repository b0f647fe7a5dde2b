#include "IO/ImageReading.h"

#include "Core/Base/NumberText.h"
#include "IO/DicomSeries.h"
#include "IO/FilePath.h"
#include "IO/ItkImage.h"
#include "IO/NiftiFile.h"
#include "IO/TextHeader.h"

#include <itkGDCMImageIO.h>
#include <itkMINCImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <array>
#include <fstream>

namespace fs = std::filesystem;

namespace innergs {
namespace {

enum class Format { Nifti, Nrrd, Meta, Minc, Dicom };

std::string firstBytes(const fs::path& path, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

/// By content where the format has a magic number, else by extension, so that a reader never sees a foreign
/// file.
Format formatOf(const fs::path& path) {
  const std::string head = firstBytes(path, 132), extension = fullExtension(path);
  if (head.starts_with("NRRD000")) return Format::Nrrd;
  if (head.size() == 132 && head.ends_with("DICM")) return Format::Dicom;
  if (head.starts_with("\x89HDF\r\n\x1a\n") && extension.starts_with(".mnc")) return Format::Minc;
  if (head.starts_with("CDF") && extension.starts_with(".mnc"))
    throw Error(ErrorCode::UnsupportedImage,
                quoted(path) + " is a MINC1 file; convert it with mincconvert -2.");
  for (const char* nifti : {".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"})
    if (extension == nifti) return Format::Nifti;
  if ((extension == ".mha" || extension == ".mhd") && head.find('=') != std::string::npos)
    return Format::Meta;
  if (extension == ".dcm" || extension == ".ima") return Format::Dicom;
  throw Error(ErrorCode::FileFormat,
              quoted(path) + " is not an image that can be read; NIfTI, NRRD, MetaImage, MINC2 and "
                             "DICOM folders can.");
}

itk::ImageIOBase::Pointer makeReader(Format format) {
  switch (format) {
  case Format::Nifti:
    return itk::NiftiImageIO::New().GetPointer();
  case Format::Nrrd:
    return itk::NrrdImageIO::New().GetPointer();
  case Format::Meta:
    return itk::MetaImageIO::New().GetPointer();
  case Format::Minc:
    return itk::MINCImageIO::New().GetPointer();
  case Format::Dicom:
    return itk::GDCMImageIO::New().GetPointer();
  }
  return nullptr;
}

/// MINC's world is RAS. Later ITK versions can turn it into LPS themselves; this does it for all.
template <typename Io>
void useMincWorld(Io& io) {
  if constexpr (requires { io.SetRAStoLPS(false); }) io.SetRAStoLPS(false);
}
void turnRasToLps(GridGeometry& geometry) {
  for (int row = 0; row < 2; ++row) {
    geometry.origin[row] = -geometry.origin[row];
    for (double& component : geometry.direction[row])
      component = -component;
  }
}

std::int64_t chooseFrame(const ItkHeader& header, const ReadOptions& options, const std::string& what) {
  const std::string range = "0 to " + std::to_string(header.frames - 1);
  if (!options.frame && header.frames > 1)
    throw Error(ErrorCode::UnsupportedImage, what + " is a 4D file with " + std::to_string(header.frames) +
                                                 " frames and a 3D image is needed; choose a frame (" +
                                                 range + ").");
  const std::int64_t frame = options.frame.value_or(0);
  if (frame < 0 || frame >= header.frames)
    throw Error(ErrorCode::InvalidArgument,
                what + " has " + std::to_string(header.frames) + (header.frames == 1 ? " frame" : " frames") +
                    ", so there is no frame " + std::to_string(frame) + "; choose one (" + range + ").");
  return frame;
}

std::vector<float> readVoxels(itk::ImageIOBase& io, const ItkHeader& header, std::int64_t frame, bool oneFile,
                              const std::string& what, const fs::path& path) {
  const auto voxels = static_cast<std::size_t>(header.geometry.voxelCount());
  const double bytes = double(voxels) * double(header.frames) * io.GetComponentSize();
  constexpr double largestDeflateRatio = 1032;
  if (oneFile && bytes > largestDeflateRatio * double(fs::file_size(path)))
    throw Error(ErrorCode::FileFormat, what + " is truncated or damaged; copy or export it again.");
  checkMemoryFor(bytes + double(voxels) * sizeof(float), what);

  itk::ImageIORegion all(io.GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis)
    all.SetSize(axis, io.GetDimensions(axis));
  io.SetIORegion(all);
  std::vector<std::byte> buffer(static_cast<std::size_t>(bytes));
  io.Read(buffer.data());
  std::vector<float> result(voxels);
  const auto index = static_cast<std::size_t>(frame);
  if (header.interleaved)
    convertVoxels(io.GetComponentType(), buffer.data(), index, static_cast<std::size_t>(header.frames),
                  result);
  else
    convertVoxels(io.GetComponentType(), buffer.data(), index * voxels, 1, result);
  return result;
}

} // namespace

LoadedImage loadImage(const fs::path& given, const ReadOptions& options) {
  std::error_code ignored;
  if (fs::is_directory(given, ignored)) {
    DicomSeries series = readDicomSeries(given, options.series);
    const std::string what = quoted(given);
    checkGeometry(series.volume.geometry, what);
    chooseFrame({series.volume.geometry, 1, false}, options, what);
    return {std::move(series.volume), series.sliceThickness, true};
  }
  checkInputFile(given);
  if (options.series)
    throw Error(ErrorCode::InvalidArgument,
                quoted(given) + " is a file; only a DICOM folder has series to choose from.");
  fs::path path = given;
  const Format format = formatOf(path);
  if (format == Format::Nifti && fullExtension(path).starts_with(".img")) {
    if (fullExtension(path) == ".img.gz") path.replace_extension();
    path.replace_extension(".hdr");
    checkInputFile(path);
  }
  const std::string what = quoted(given);
  std::optional<NiftiHeader> nifti;
  if (format == Format::Nifti) nifti = readNiftiHeader(path);
  std::optional<MetaHeader> meta;
  if (format == Format::Meta) meta.emplace(path, what);
  bool sequence = format == Format::Nrrd && NrrdHeader(path, what).sequence;

  const std::string damaged =
      what + " is truncated, damaged or of an unsupported variant; copy or export it again.";
  return withItk(ErrorCode::FileFormat, damaged, [&] {
    const itk::ImageIOBase::Pointer io = makeReader(format);
    if (auto* minc = dynamic_cast<itk::MINCImageIO*>(io.GetPointer())) useMincWorld(*minc);
    io->SetFileName(utf8(path));
    io->ReadImageInformation();
    if (format == Format::Minc) sequence = io->GetMetaDataDictionary().HasKey("tstep");
    ItkHeader header = describe(*io, what, sequence);
    if (format == Format::Minc) turnRasToLps(header.geometry);
    if (nifti) header.geometry.origin = originInMillimetres(*nifti, header.geometry.origin);
    checkGeometry(header.geometry, what);
    const std::int64_t frame = chooseFrame(header, options, what);

    if (meta && !meta->holds(static_cast<std::uint64_t>(io->GetImageSizeInBytes())))
      throw Error(ErrorCode::FileFormat, damaged);
    LoadedImage loaded;
    loaded.volume.geometry = header.geometry;
    loaded.frames = header.frames;
    if (nifti) loaded.frameSeconds = nifti->frameSeconds;
    if (format == Format::Minc && header.frames > 1)
      itk::ExposeMetaData<double>(io->GetMetaDataDictionary(), "tstep", loaded.frameSeconds);
    loaded.tracked = meta && meta->tracked;
    if (format == Format::Dicom) {
      checkDicomPixels(*io, what);
      std::string thickness;
      itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0018|0050", thickness);
      loaded.sliceThickness = leadingNumber(thickness).value_or(0);
      loaded.slicesAreAlongK = true;
    }
    const std::string extension = fullExtension(path);
    const bool oneFile =
        format != Format::Minc && format != Format::Dicom && extension != ".nhdr" && extension != ".mhd";
    loaded.volume.voxels =
        nifti ? readNiftiFrame(*nifti, frame, given) : readVoxels(*io, header, frame, oneFile, what, path);
    return loaded;
  });
}

} // namespace innergs
