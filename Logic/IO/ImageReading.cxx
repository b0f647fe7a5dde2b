#include "IO/ImageReading.h"

#include "Core/Base/NumberText.h"
#include "Core/Image/SliceAxis.h"
#include "IO/BidsSidecar.h"
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

#include <algorithm>
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

/// Detects the format by content if it has a magic number, else by extension, so that no reader gets a file
/// of another format.
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

/// MINC's world coordinates are RAS. Newer ITK versions can convert them to LPS; this works with all
/// versions.
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

/// A file whose header has been read and checked.
struct OpenFile {
  std::filesystem::path given, path;
  std::string what, damaged; // the file's name, and the message if it is damaged
  Format format = Format::Nifti;
  itk::ImageIOBase::Pointer io;
  ItkHeader header;
  std::optional<NiftiHeader> nifti;
  std::optional<MetaHeader> meta;
  std::optional<NrrdHeader> nrrd;
  double frameSeconds = 0;
};

std::vector<std::vector<float>> readVoxels(const OpenFile& file, std::int64_t first, std::int64_t count) {
  if (file.meta && !file.meta->holds(static_cast<std::uint64_t>(file.io->GetImageSizeInBytes())))
    throw Error(ErrorCode::FileFormat, file.damaged);
  if (file.nifti) return readNiftiFrames(*file.nifti, first, count, file.given);
  itk::ImageIOBase& io = *file.io;
  const ItkHeader& header = file.header;
  const std::string extension = fullExtension(file.path);
  const bool oneFile = file.format != Format::Minc && file.format != Format::Dicom && extension != ".nhdr" &&
                       extension != ".mhd";
  const auto voxels = static_cast<std::size_t>(header.geometry.voxelCount());
  const double bytes = double(voxels) * double(header.frames) * io.GetComponentSize();
  constexpr double largestDeflateRatio = 1032;
  if (oneFile && bytes > largestDeflateRatio * double(fs::file_size(file.path)))
    throw Error(ErrorCode::FileFormat, file.what + " is truncated or damaged; copy or export it again.");
  checkMemoryFor(bytes + double(voxels) * double(count) * sizeof(float), file.what);

  itk::ImageIORegion all(io.GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis)
    all.SetSize(axis, io.GetDimensions(axis));
  io.SetIORegion(all);
  std::vector<std::byte> buffer(static_cast<std::size_t>(bytes));
  io.Read(buffer.data());
  std::vector<std::vector<float>> frames(static_cast<std::size_t>(count), std::vector<float>(voxels));
  for (std::int64_t f = 0; f < count; ++f) {
    const auto index = static_cast<std::size_t>(first + f);
    if (header.interleaved)
      convertVoxels(io.GetComponentType(), buffer.data(), index, static_cast<std::size_t>(header.frames),
                    frames[f]);
    else
      convertVoxels(io.GetComponentType(), buffer.data(), index * voxels, 1, frames[f]);
  }
  return frames;
}

/// Calls `use` with the open file; whatever ITK throws becomes an Error. vectors: several values per voxel
/// are expected.
template <class Use>
auto withOpenFile(const fs::path& given, const Use& use, bool vectors = false) {
  checkInputFile(given);
  OpenFile file;
  file.given = file.path = given;
  file.format = formatOf(given);
  if (file.format == Format::Nifti && fullExtension(given).starts_with(".img")) {
    if (fullExtension(given) == ".img.gz") file.path.replace_extension();
    file.path.replace_extension(".hdr");
    checkInputFile(file.path);
  }
  file.what = quoted(given);
  file.damaged = file.what + " is truncated, damaged or of an unsupported variant; copy or export it again.";
  if (file.format == Format::Nifti) file.nifti = readNiftiHeader(file.path);
  if (file.format == Format::Meta) file.meta.emplace(file.path, file.what);
  if (file.format == Format::Nrrd) file.nrrd.emplace(file.path, file.what);
  return withItk(ErrorCode::FileFormat, file.damaged, [&] {
    file.io = makeReader(file.format);
    if (auto* minc = dynamic_cast<itk::MINCImageIO*>(file.io.GetPointer())) useMincWorld(*minc);
    file.io->SetFileName(utf8(file.path));
    file.io->ReadImageInformation();
    itk::MetaDataDictionary& entries = file.io->GetMetaDataDictionary();
    const bool sequence =
        file.format == Format::Minc ? entries.HasKey("tstep") : file.nrrd && file.nrrd->sequence;
    file.header = describe(*file.io, file.what, sequence || vectors);
    GridGeometry& geometry = file.header.geometry;
    if (file.format == Format::Minc) turnRasToLps(geometry);
    if (file.nifti) {
      geometry.origin = originInMillimetres(*file.nifti, geometry.origin);
      file.frameSeconds = file.nifti->frameSeconds;
    }
    if (file.format == Format::Minc && file.header.frames > 1)
      itk::ExposeMetaData<double>(entries, "tstep", file.frameSeconds);
    checkGeometry(geometry, file.what);
    return use(file);
  });
}

constexpr const char* kDicomThickness = "DICOM (0018,0050)";

/// Thickness and times of the slices, as the header or the sidecar beside a NIfTI says. How far the slices
/// lie apart tells which axis counts them; what is said of another axis does not count.
void describeSlices(const OpenFile& file, LoadedImage& loaded) {
  const GridGeometry& grid = loaded.volume.geometry;
  const int axis = sliceAxisOf(grid.spacing);
  const auto say = [&](double thickness, const std::string& from) {
    if (!(thickness > 0)) return;
    loaded.sliceThickness = thickness;
    loaded.thicknessFrom = from;
  };
  if (file.nrrd) say(file.nrrd->thickness[static_cast<std::size_t>(axis)], "NRRD thicknesses");
  if (file.meta) say(file.meta->thickness[static_cast<std::size_t>(axis)], "MetaImage ElementSize");
  if (!file.nifti) return;
  const fs::path sidecar = sidecarOf(file.given);
  const int counted = file.nifti->sliceAxis;
  const BidsSlices bids = readBidsSlices(sidecar, counted >= 0 ? counted : axis, grid);
  if (bids.axis == axis) {
    say(bids.thickness, "SliceThickness in " + quoted(sidecar.filename()));
    loaded.sliceTimes = bids.times;
  }
  if (loaded.sliceTimes.empty() && counted == axis) loaded.sliceTimes = file.nifti->sliceSeconds;
  const auto& times = loaded.sliceTimes;
  if (std::all_of(times.begin(), times.end(), [&](double t) { return t == times.front(); }))
    loaded.sliceTimes.clear(); // all at once
}

} // namespace

LoadedImage loadImage(const fs::path& given, const ReadOptions& options) {
  std::error_code ignored;
  if (fs::is_directory(given, ignored)) {
    DicomSeries series = readDicomSeries(given, options.series);
    const std::string what = quoted(given);
    checkGeometry(series.volume.geometry, what);
    chooseFrame({series.volume.geometry, 1, false}, options, what);
    LoadedImage loaded;
    loaded.volume = std::move(series.volume);
    loaded.sliceThickness = series.sliceThickness;
    loaded.slicesAreAlongK = true;
    if (loaded.sliceThickness > 0) loaded.thicknessFrom = kDicomThickness;
    loaded.sliceTimes = std::move(series.sliceTimes);
    loaded.poses = std::move(series.poses);
    loaded.remarks = std::move(series.remarks);
    return loaded;
  }
  if (options.series) {
    checkInputFile(given);
    throw Error(ErrorCode::InvalidArgument,
                quoted(given) + " is a file; only a DICOM folder has series to choose from.");
  }
  return withOpenFile(given, [&](const OpenFile& file) {
    const std::int64_t frame = chooseFrame(file.header, options, file.what);
    LoadedImage loaded;
    loaded.volume.geometry = file.header.geometry;
    loaded.frames = file.header.frames;
    loaded.frameSeconds = file.frameSeconds;
    loaded.tracked = file.meta && file.meta->tracked;
    if (loaded.tracked) loaded.sweepFields = file.meta->fields;
    if (file.format == Format::Dicom) {
      checkDicomPixels(*file.io, file.what);
      std::string thickness;
      itk::ExposeMetaData<std::string>(file.io->GetMetaDataDictionary(), "0018|0050", thickness);
      loaded.sliceThickness = leadingNumber(thickness).value_or(0);
      if (loaded.sliceThickness > 0) loaded.thicknessFrom = kDicomThickness;
      loaded.slicesAreAlongK = true;
    }
    describeSlices(file, loaded);
    loaded.volume.voxels = std::move(readVoxels(file, frame, 1).front());
    return loaded;
  });
}

LoadedFrames loadFrames(const fs::path& given) {
  return withOpenFile(given, [&](const OpenFile& file) {
    LoadedFrames loaded;
    loaded.geometry = file.header.geometry;
    loaded.frameSeconds = file.frameSeconds;
    if (file.nifti) {
      loaded.firstSeconds = file.nifti->firstSeconds;
      loaded.sliceAxis = file.nifti->sliceAxis;
      loaded.sliceSeconds = file.nifti->sliceSeconds;
      // The fifth axis holds vectors, and so do all intents from vector of distances to quaternion.
      constexpr int symmetricMatrix = 1005, firstOfVectors = 1006, lastOfVectors = 1010, shape = 2005;
      loaded.vectors = file.nifti->size[4] > 1 || file.nifti->intent == symmetricMatrix ||
                       file.nifti->intent == shape ||
                       (file.nifti->intent >= firstOfVectors && file.nifti->intent <= lastOfVectors);
    }
    if (file.nrrd) {
      loaded.indexName = file.nrrd->indexName;
      loaded.indexUnit = file.nrrd->indexUnit;
      loaded.indexValues = file.nrrd->indexValues;
    }
    if (!loaded.vectors) loaded.frames = readVoxels(file, 0, file.header.frames);
    return loaded;
  });
}

VectorImage loadVectors(const fs::path& given) {
  return withOpenFile(
      given,
      [](const OpenFile& file) {
        return VectorImage{file.header.geometry, readVoxels(file, 0, file.header.frames)};
      },
      true);
}

} // namespace innergs
