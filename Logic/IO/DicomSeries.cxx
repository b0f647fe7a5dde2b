#include "IO/DicomSeries.h"

#include "IO/FilePath.h"
#include "IO/ItkImage.h"

#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace innergs {
namespace {

struct Slice {
  GridGeometry geometry; // one slice
  double thickness = 0;
  std::vector<float> voxels;
};

std::string tag(const itk::ImageIOBase& io, const char* key) {
  std::string value;
  itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), key, value);
  while (!value.empty() && (value.back() == ' ' || value.back() == '\0'))
    value.pop_back();
  return value;
}

itk::GDCMImageIO::Pointer openDicom(const std::string& file) {
  auto io = itk::GDCMImageIO::New();
  io->SetFileName(file);
  io->ReadImageInformation();
  return io;
}

Slice readSlice(const std::string& file) {
  const std::string what = quoted(std::filesystem::path(std::u8string(file.begin(), file.end())));
  return withItk(ErrorCode::FileFormat, what + " is a damaged or unsupported DICOM file; export it again.",
                 [&] {
                   const auto io = openDicom(file);
                   const ItkHeader header = describe(*io, what);
                   checkDicomPixels(*io, what);
                   Slice slice{header.geometry, std::atof(tag(*io, "0018|0050").c_str()), {}};
                   const double count = double(header.geometry.size[0]) * double(header.geometry.size[1]) *
                                        double(header.geometry.size[2]);
                   checkMemoryFor(count * (sizeof(float) + io->GetComponentSize()), what);
                   std::vector<std::byte> buffer(static_cast<std::size_t>(io->GetImageSizeInBytes()));
                   io->Read(buffer.data());
                   slice.voxels.resize(static_cast<std::size_t>(count));
                   convertVoxels(io->GetComponentType(), buffer.data(), 0, 1, slice.voxels);
                   return slice;
                 });
}

std::vector<std::string> filesOfOnlySeries(const std::filesystem::path& folder) {
  const std::string what = quoted(folder);
  return withItk(
      ErrorCode::FileFormat, what + " holds DICOM files that cannot be read; export them again.", [&] {
        const auto names = itk::GDCMSeriesFileNames::New();
        names->SetUseSeriesDetails(true);
        names->SetInputDirectory(utf8(folder));
        const std::vector<std::string> series = names->GetSeriesUIDs();
        if (series.empty())
          throw Error(ErrorCode::FileFormat,
                      what + " is a folder without a DICOM series; give an image file or a DICOM folder.");
        if (series.size() > 1) {
          std::string list;
          for (const std::string& uid : series) {
            const std::vector<std::string> files = names->GetFileNames(uid);
            const auto first = openDicom(files.at(0));
            if (!list.empty()) list += "; ";
            list.append("'").append(tag(*first, "0008|103e")).append("' ").append(tag(*first, "0020|000e"));
            list.append(" (")
                .append(std::to_string(files.size()))
                .append(files.size() == 1 ? " image)" : " images)");
          }
          throw Error(ErrorCode::FileFormat,
                      what + " holds " + std::to_string(series.size()) +
                          " DICOM series, put the one to use in a folder of its own: " + list + ".");
        }
        return std::vector<std::string>(names->GetFileNames(series.front()));
      });
}

/// Every slice must have the lattice of the first and stand a whole number of even steps from it.
void checkSlices(const std::vector<Slice>& slices, const Vec3& step, const std::string& what) {
  const GridGeometry& first = slices.front().geometry;
  const double gap = norm(step);
  if (!(gap > 1e-4))
    throw Error(ErrorCode::UnsupportedImage, what + " holds several images per slice position (a time series "
                                                    "or several echoes); convert it to NIfTI and "
                                                    "choose one with --frame N.");
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const GridGeometry& g = slices[k].geometry;
    bool same = g.size == first.size;
    for (int i = 0; i < 3; ++i) {
      same = same && (i == 2 || std::abs(g.spacing[i] - first.spacing[i]) < 1e-4 * first.spacing[i]);
      for (int j = 0; j < 2; ++j)
        same = same && std::abs(g.direction[i][j] - first.direction[i][j]) < 1e-4;
    }
    if (!same)
      throw Error(ErrorCode::Geometry,
                  what + " holds slices of different size, spacing or orientation; put only the slices "
                         "of one stack in the folder.");
    if (k == 0) continue;
    const double distance = norm(g.origin - slices[k - 1].geometry.origin);
    if (distance < 1e-3 * gap)
      throw Error(ErrorCode::UnsupportedImage,
                  what + " holds several images per slice position (a time series or several "
                         "echoes); convert it to NIfTI and choose one with --frame N.");
    if (norm(g.origin - (first.origin + double(k) * step)) > 0.02 * gap + 1e-3) {
      char numbers[80];
      std::snprintf(numbers, sizeof(numbers), "%.3f mm where %.3f mm were expected", distance, gap);
      throw Error(ErrorCode::Geometry, what + " holds slices that are not evenly spaced (" + numbers +
                                           "); add the missing slices or resample it first.");
    }
  }
}

} // namespace

void checkDicomPixels(const itk::ImageIOBase& io, const std::string& what) {
  const std::uint64_t bits = std::strtoull(tag(io, "0028|0100").c_str(), nullptr, 10);
  const std::uint64_t bytes = io.GetImageSizeInPixels() * io.GetNumberOfComponents() * bits / 8;
  std::ifstream in(io.GetFileName(), std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto number = [&](std::size_t at) { // little-endian
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 4 && at + i < file.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(file[at + i])} << 8 * i;
    return value;
  };
  const std::string pixelData("\xE0\x7F\x10\x00", 4);
  for (std::size_t at = file.find(pixelData); at != std::string::npos; at = file.find(pixelData, at + 1)) {
    const bool explicitType = file.compare(at + 4, 2, "OW") == 0 || file.compare(at + 4, 2, "OB") == 0;
    const std::size_t start = at + (explicitType ? 12 : 8);
    const std::uint64_t length = number(start - 4);
    if ((length == bytes || length == bytes + 1) && file.size() < start + bytes)
      throw Error(ErrorCode::FileFormat, what + " is truncated; export or copy it again.");
  }
}

DicomSeries readDicomSeries(const std::filesystem::path& folder) {
  const std::string what = quoted(folder);
  std::vector<Slice> slices;
  for (const std::string& file : filesOfOnlySeries(folder))
    slices.push_back(readSlice(file));
  DicomSeries series{{slices.front().geometry, {}}, slices.front().thickness};
  if (slices.size() == 1) {
    series.volume.voxels = std::move(slices.front().voxels);
    return series;
  }
  if (std::any_of(slices.begin(), slices.end(), [](const Slice& s) { return s.geometry.size[2] != 1; }))
    throw Error(ErrorCode::UnsupportedImage,
                what + " holds several multi-frame DICOM files; give the path of one of them.");

  const Mat3& direction = slices.front().geometry.direction;
  const Vec3 normal = cross(column(direction, 0), column(direction, 1));
  std::stable_sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) {
    return dot(a.geometry.origin, normal) < dot(b.geometry.origin, normal);
  });
  const Vec3 step =
      (1.0 / double(slices.size() - 1)) * (slices.back().geometry.origin - slices.front().geometry.origin);
  checkSlices(slices, step, what);

  GridGeometry& geometry = series.volume.geometry;
  geometry = slices.front().geometry;
  geometry.size[2] = static_cast<std::int64_t>(slices.size());
  geometry.spacing[2] = norm(step);
  for (int row = 0; row < 3; ++row)
    geometry.direction[row][2] = step[row] / geometry.spacing[2];
  checkMemoryFor(double(geometry.voxelCount()) * sizeof(float), what);
  series.volume.voxels.reserve(static_cast<std::size_t>(geometry.voxelCount()));
  for (Slice& slice : slices) {
    series.volume.voxels.insert(series.volume.voxels.end(), slice.voxels.begin(), slice.voxels.end());
    slice.voxels = {};
  }
  return series;
}

} // namespace innergs
