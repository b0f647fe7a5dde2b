#include "IO/DicomSeries.h"

#include "Core/Base/NumberText.h"
#include "IO/DicomTimes.h"
#include "IO/FilePath.h"
#include "IO/ItkImage.h"

#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>

namespace innergs {
namespace {

struct Slice {
  GridGeometry geometry; // one slice
  double thickness = 0;
  std::vector<float> voxels;
  std::string acquired, triggered; // AcquisitionTime and TriggerTime, as stored
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
  const std::string what = quoted(pathOf(file));
  return withItk(ErrorCode::FileFormat, what + " is a damaged or unsupported DICOM file; export it again.",
                 [&] {
                   const auto io = openDicom(file);
                   const ItkHeader header = describe(*io, what);
                   checkDicomPixels(*io, what);
                   Slice slice{header.geometry,
                               leadingNumber(tag(*io, "0018|0050")).value_or(0),
                               {},
                               tag(*io, "0008|0032"),
                               tag(*io, "0018|1060")};
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

/// The header of one image: what distinguishes the images of a folder.
struct Header {
  std::string file, uid, description, number;
  GridGeometry geometry;
  double thickness = 0;
  std::map<std::string, std::string> details; // what tells repeated positions apart: readable name, value
};

/// Tags that may differ between images of one series at the same position.
constexpr std::array<std::pair<const char*, const char*>, 7> kDetails{{{"0018|0081", "echo time"},
                                                                       {"0008|0008", "type"},
                                                                       {"0020|0100", "time point"},
                                                                       {"0018|1060", "trigger time"},
                                                                       {"0018|9087", "b-value"},
                                                                       {"0020|0012", "acquisition"},
                                                                       {"0008|0032", "acquired at"}}};

Header readHeader(const std::string& file) {
  const auto io = openDicom(file);
  Header header;
  header.file = file;
  header.uid = tag(*io, "0020|000e");
  header.description = tag(*io, "0008|103e");
  header.number = tag(*io, "0020|0011");
  header.thickness = leadingNumber(tag(*io, "0018|0050")).value_or(0);
  GridGeometry& g = header.geometry;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const bool given = axis < io->GetNumberOfDimensions();
    g.size[axis] = given ? static_cast<std::int64_t>(io->GetDimensions(axis)) : 1;
    g.spacing[axis] = given ? io->GetSpacing(axis) : 1;
    g.origin[axis] = given ? io->GetOrigin(axis) : 0;
    for (unsigned row = 0; given && row < 3; ++row)
      g.direction[row][axis] = row < io->GetDirection(axis).size() ? io->GetDirection(axis)[row] : 0;
  }
  for (const auto& [key, name] : kDetails)
    header.details[name] = tag(*io, key);
  return header;
}

using Headers = std::vector<Header>;

/// Groups headers of a kind, in the order in which the kinds first occur.
template <class Same>
std::vector<Headers> divided(const Headers& headers, const Same& same) {
  std::vector<Headers> parts;
  for (const Header& header : headers) {
    const auto found = std::find_if(parts.begin(), parts.end(),
                                    [&](const Headers& part) { return same(part.front(), header); });
    if (found == parts.end())
      parts.push_back({header});
    else
      found->push_back(header);
  }
  return parts;
}

bool sameStack(const Header& a, const Header& b) {
  const GridGeometry &g = a.geometry, &h = b.geometry;
  bool same = a.uid == b.uid && a.number == b.number && g.size == h.size;
  for (int i = 0; i < 3; ++i) {
    same = same && (i == 2 || std::abs(g.spacing[i] - h.spacing[i]) < 1e-4 * g.spacing[i]);
    for (int j = 0; j < 2; ++j)
      same = same && std::abs(g.direction[i][j] - h.direction[i][j]) < 1e-3;
  }
  return same;
}

bool repeatsAPosition(const Headers& headers) {
  const Mat3& direction = headers.front().geometry.direction;
  const Vec3 normal = cross(column(direction, 0), column(direction, 1));
  std::vector<double> places;
  for (const Header& header : headers)
    places.push_back(dot(header.geometry.origin, normal));
  std::sort(places.begin(), places.end());
  return std::adjacent_find(places.begin(), places.end(), [](double a, double b) { return b - a < 1e-3; }) !=
         places.end();
}

/// Separates echoes, phases or time points if one of the details distinguishes them.
std::vector<std::pair<Headers, std::string>> withoutRepeats(const Headers& headers) {
  if (headers.size() > 1 && headers.front().geometry.size[2] == 1 && repeatsAPosition(headers))
    for (const auto& [key, name] : kDetails) {
      const auto parts = divided(headers, [n = name](const Header& a, const Header& b) {
        return a.details.at(n) == b.details.at(n);
      });
      const bool apart = std::all_of(parts.begin(), parts.end(), [&](const Headers& part) {
        return part.size() > 1 && part.size() * parts.size() == headers.size() && !repeatsAPosition(part);
      });
      if (parts.size() < 2 || !apart) continue;
      std::vector<std::pair<Headers, std::string>> named;
      for (const Headers& part : parts)
        named.emplace_back(part, std::string(name) + " " + part.front().details.at(name));
      return named;
    }
  return {{headers, ""}};
}

DicomEntry entryOf(const Headers& headers, const std::string& detail) {
  const Header& first = headers.front();
  DicomEntry entry;
  entry.description = first.description;
  entry.detail = detail;
  for (const Header& header : headers)
    entry.files.push_back(header.file);
  entry.images = static_cast<std::int64_t>(headers.size()) * first.geometry.size[2];
  entry.size = {first.geometry.size[0], first.geometry.size[1]};
  entry.thickness = first.thickness;
  const Mat3& direction = first.geometry.direction;
  const Vec3 normal = cross(column(direction, 0), column(direction, 1));
  int main = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(normal[axis]) > std::abs(normal[main])) main = axis;
  constexpr std::array planes{"sagittal", "coronal", "axial"};
  entry.plane = planes[static_cast<std::size_t>(main)];
  constexpr double degrees = 57.29577951308232;
  entry.tilt = degrees * std::acos(std::min(1.0, std::abs(normal[main]) / norm(normal)));
  return entry;
}

[[noreturn]] void refuseRepeatedSlices(const std::string& what) {
  throw Error(ErrorCode::UnsupportedImage,
              what + " holds several images per slice position (a time series or several echoes); convert it "
                     "to a NIfTI file and choose one of its frames.");
}

void checkAlike(const std::vector<Slice>& slices, const std::string& what) {
  const GridGeometry& first = slices.front().geometry;
  for (const Slice& slice : slices) {
    const GridGeometry& g = slice.geometry;
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
  }
}

/// Whether every slice lies a whole number of even steps from the first one.
bool areEven(const std::vector<Vec3>& origins, const Vec3& step) {
  for (std::size_t k = 1; k < origins.size(); ++k)
    if (norm(origins[k] - (origins.front() + double(k) * step)) > 0.02 * norm(step) + 1e-3) return false;
  return true;
}

/// Refuses gaps that are whole multiples of the smallest one, unless each wider one has an equal neighbour:
/// head CT, for example, is acquired with slices twice as far apart above the skull base.
void checkComplete(const std::vector<double>& gaps, const std::string& what) {
  const double smallest = *std::min_element(gaps.begin(), gaps.end());
  std::vector<double> multiples;
  for (const double gap : gaps) {
    multiples.push_back(std::round(gap / smallest));
    if (std::abs(gap - multiples.back() * smallest) > 0.05 * smallest) return;
  }
  for (std::size_t k = 0; k < gaps.size(); ++k)
    if (multiples[k] > 1 && !(k > 0 && multiples[k - 1] == multiples[k]) &&
        !(k + 1 < gaps.size() && multiples[k + 1] == multiples[k]))
      throw Error(
          ErrorCode::Geometry,
          what +
              formatted(" holds slices that are not evenly spaced (%.3f mm where %.3f mm were expected), as "
                        "if some were missing; add the missing slices or resample it first.",
                        gaps[k], smallest));
}

/// Lays out parallel slices, sorted along the normal, on a grid with that axis; those that are not there
/// get poses.
void layOut(const std::vector<Slice>& slices, const Vec3& normal, DicomSeries& series,
            const std::string& what) {
  checkAlike(slices, what);
  std::vector<Vec3> origins;
  std::vector<double> gaps;
  for (const Slice& slice : slices) {
    origins.push_back(slice.geometry.origin);
    if (origins.size() > 1) gaps.push_back(dot(origins.back() - origins[origins.size() - 2], normal));
  }
  const Vec3 across = origins.back() - origins.front();
  const Vec3 step = (1.0 / double(gaps.size())) * across;
  const double mean = dot(step, normal);
  if (!(mean > 1e-4) || *std::min_element(gaps.begin(), gaps.end()) < 1e-3 * mean) refuseRepeatedSlices(what);
  GridGeometry& geometry = series.volume.geometry;
  geometry.size[2] = static_cast<std::int64_t>(slices.size());
  if (areEven(origins, step) && norm(cross(step, normal)) <= 1e-3 * norm(step)) {
    geometry.spacing[2] = norm(step);
    for (int row = 0; row < 3; ++row)
      geometry.direction[row][2] = step[row] / geometry.spacing[2];
    return;
  }
  const double tolerance = 0.02 * mean + 1e-3;
  double shift = 0; // within the planes, mm
  bool uneven = false;
  for (std::size_t k = 0; k < origins.size(); ++k) {
    const Vec3 x = origins[k] - origins.front();
    shift = std::max(shift, norm(cross(x, normal)));
    uneven = uneven || std::abs(dot(x, normal) - double(k) * mean) > tolerance;
  }
  if (uneven) checkComplete(gaps, what);
  std::sort(gaps.begin(), gaps.end());
  geometry.spacing[2] = std::min(mean, gaps[gaps.size() / 2]);
  for (int row = 0; row < 3; ++row)
    geometry.direction[row][2] = normal[row];
  const Vec3 apart = geometry.spacing[2] * normal;
  geometry.origin = origins.front() + 0.5 * (across - double(slices.size() - 1) * apart);
  for (std::size_t k = 0; k < slices.size(); ++k)
    series.poses.push_back({{}, origins[k] - (geometry.origin + double(k) * apart)});
  if (uneven)
    series.remarks.push_back(what + formatted(" holds slices %g to %g mm apart: each is used where it lies.",
                                              gaps.front(), gaps.back()));
  if (shift > tolerance)
    series.remarks.push_back(what + formatted(" holds slices displaced within their planes, by up to %.1f mm "
                                              "(a tilted gantry, for example): each is used where it lies.",
                                              shift));
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

std::vector<DicomEntry> listDicomSeries(const std::filesystem::path& folder) {
  const std::string what = quoted(folder);
  return withItk(
      ErrorCode::FileFormat, what + " holds DICOM files that cannot be read; export them again.", [&] {
        const auto names = itk::GDCMSeriesFileNames::New();
        names->SetInputDirectory(utf8(folder));
        Headers headers;
        for (const std::string& uid : names->GetSeriesUIDs())
          for (const std::string& file : names->GetFileNames(uid))
            headers.push_back(readHeader(file));
        if (headers.empty())
          throw Error(ErrorCode::FileFormat,
                      what + " is a folder without a DICOM series; give an image file or a DICOM folder.");
        std::vector<Headers> stacks = divided(headers, sameStack);
        std::stable_sort(stacks.begin(), stacks.end(), [](const Headers& a, const Headers& b) {
          const auto number = [](const Headers& of) { return leadingNumber(of.front().number).value_or(0); };
          return std::pair(number(a), a.front().uid) < std::pair(number(b), b.front().uid);
        });
        std::vector<DicomEntry> entries;
        for (const Headers& stack : stacks)
          for (const auto& [part, detail] : withoutRepeats(stack))
            entries.push_back(entryOf(part, detail));
        return entries;
      });
}

std::string textOf(const DicomEntry& entry) {
  std::string text = entry.description.empty() ? "without a description" : "'" + entry.description + "'";
  if (!entry.detail.empty()) text += ", " + entry.detail;
  text += formatted(", %lld image%s of %lld x %lld, %s", static_cast<long long>(entry.images),
                    entry.images == 1 ? "" : "s", static_cast<long long>(entry.size[0]),
                    static_cast<long long>(entry.size[1]), entry.plane.c_str());
  if (entry.tilt >= 0.5) text += formatted(" tilted by %.0f degrees", entry.tilt);
  if (entry.thickness > 0) text += formatted(", %g mm thick", entry.thickness);
  return text;
}

DicomSeries readDicomSeries(const std::filesystem::path& folder, std::optional<int> chosen) {
  const std::string what = quoted(folder);
  const std::vector<DicomEntry> entries = listDicomSeries(folder);
  const auto count = static_cast<int>(entries.size());
  if ((!chosen && count > 1) || (chosen && (*chosen < 1 || *chosen > count))) {
    std::string list;
    for (int n = 0; n < count; ++n)
      list += (n ? "; " : "") + std::to_string(n + 1) + ": " + textOf(entries[static_cast<std::size_t>(n)]);
    throw Error(chosen ? ErrorCode::InvalidArgument : ErrorCode::FileFormat,
                what + " holds " + std::to_string(count) + " DICOM series" +
                    (chosen ? ", so there is no series " + std::to_string(*chosen) : "") +
                    "; choose a series: " + list + ".");
  }
  std::vector<Slice> slices;
  for (const std::string& file : entries[static_cast<std::size_t>(chosen.value_or(1) - 1)].files)
    slices.push_back(readSlice(file));
  DicomSeries series{{slices.front().geometry, {}}, slices.front().thickness, {}, {}, {}};
  if (slices.size() == 1) {
    series.volume.voxels = std::move(slices.front().voxels);
    return series;
  }
  if (std::any_of(slices.begin(), slices.end(), [](const Slice& s) { return s.geometry.size[2] != 1; }))
    throw Error(ErrorCode::UnsupportedImage,
                what + " holds several multi-frame DICOM files; give the path of one of them.");

  const Mat3& direction = slices.front().geometry.direction;
  const Vec3 across = cross(column(direction, 0), column(direction, 1));
  const Vec3 normal = (1 / norm(across)) * across;
  std::stable_sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) {
    return dot(a.geometry.origin, normal) < dot(b.geometry.origin, normal);
  });
  layOut(slices, normal, series, what);
  std::vector<std::string> acquired, triggered;
  for (const Slice& slice : slices) {
    acquired.push_back(slice.acquired);
    triggered.push_back(slice.triggered);
  }
  series.sliceTimes = dicomSliceTimes(acquired, triggered);
  const GridGeometry& geometry = series.volume.geometry;
  checkMemoryFor(double(geometry.voxelCount()) * sizeof(float), what);
  series.volume.voxels.reserve(static_cast<std::size_t>(geometry.voxelCount()));
  for (Slice& slice : slices) {
    series.volume.voxels.insert(series.volume.voxels.end(), slice.voxels.begin(), slice.voxels.end());
    slice.voxels = {};
  }
  return series;
}

} // namespace innergs
