#include "IO/TimeSeriesWriting.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/AtomicFile.h"
#include "IO/BidsSidecar.h"
#include "IO/FilePath.h"
#include "IO/VoxelWriting.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace fs = std::filesystem;

namespace innergs {
namespace {

bool isNifti(const fs::path& path) {
  return fullExtension(path).starts_with(".nii");
}

const char* nrrdType(OutputType type) {
  constexpr std::array names{"float", "unsigned char", "short", "unsigned short", "int"}; // as in OutputType
  return names.at(static_cast<std::size_t>(type));
}

/// Frames first: every version of 3D Slicer reads these.
std::string nrrdHeader(const TimeSeries& series, OutputType type) {
  const GridGeometry& g = series.geometry;
  std::string times;
  for (const double time : series.times)
    times += (times.empty() ? "" : " ") + exactText(time);
  std::string text = "NRRD0005\n";
  text += std::string("type: ") + nrrdType(type) + "\ndimension: 4\nspace: left-posterior-superior\n";
  text += "sizes: " + std::to_string(series.size());
  for (const std::int64_t n : g.size)
    text += " " + std::to_string(n);
  text += "\nspace directions: none";
  for (int axis = 0; axis < 3; ++axis)
    text += " " + nrrdVector(g.spacing[axis] * column(g.direction, axis));
  text +=
      "\nkinds: list domain domain domain\nlabels: \"time\" \"\" \"\" \"\"\nunits: \"s\" \"\" \"\" \"\"\n";
  text += "space units: \"mm\" \"mm\" \"mm\"\n";
  text += std::string("endian: ") + (std::endian::native == std::endian::little ? "little" : "big") +
          "\nencoding: gzip\nspace origin: " + nrrdVector(g.origin) + "\n";
  text += "DataNodeClassName:=vtkMRMLScalarVolumeNode\naxis 0 index type:=numeric\naxis 0 index values:=" +
          times + "\n\n";
  return text;
}

void writeSequence(const TimeSeries& series, OutputType type, const TypedVoxels& voxels,
                   const fs::path& path) {
  const std::size_t size =
      voxels.bytes() / static_cast<std::size_t>(series.geometry.voxelCount() * series.size());
  const auto* bytes = static_cast<const std::byte*>(voxels.data());
  const auto frames = static_cast<std::size_t>(series.size()),
             count = static_cast<std::size_t>(series.geometry.voxelCount());
  std::vector<std::byte> interleaved(voxels.bytes());
  for (std::size_t v = 0; v < count; ++v)
    for (std::size_t f = 0; f < frames; ++f)
      std::copy_n(bytes + (f * count + v) * size, size, interleaved.data() + (v * frames + f) * size);
  const std::string header = nrrdHeader(series, type), failed = writingFailed(path);
  writeAtomically(path, [&](const fs::path& temporary) {
    {
      std::ofstream out(temporary, std::ios::binary);
      out << header;
      if (!out.flush()) throw Error(ErrorCode::Io, failed);
    }
    writeBehind("", interleaved.data(), interleaved.size(), "ab", temporary, failed);
  });
}

/// ITK's writer supports neither the unit of time nor the time of the first frame: this takes its header for
/// one frame and adds both and the number of frames.
std::string niftiHeader(const TimeSeries& series, double interval, OutputType type, const fs::path& scratch) {
  const std::vector<float> blank(static_cast<std::size_t>(series.geometry.voxelCount()), 0.f);
  writeItkFile(scratch, series.geometry, type, TypedVoxels(blank, type, {}, scratch));
  std::string header(352, '\0');
  {
    std::ifstream in(scratch, std::ios::binary);
    in.read(header.data(), static_cast<std::streamsize>(header.size()));
  }
  std::error_code ignored;
  fs::remove(scratch, ignored);
  const auto set = [&](std::size_t offset, auto value) {
    std::memcpy(header.data() + offset, &value, sizeof(value));
  };
  constexpr char millimetresAndSeconds = 2 | 8;
  set(40, std::int16_t{4});
  set(48, static_cast<std::int16_t>(series.size()));
  set(92, static_cast<float>(interval));
  set(123, millimetresAndSeconds);
  set(136, static_cast<float>(series.times.front()));
  return header;
}

void writeNifti(const TimeSeries& series, double interval, OutputType type, const TypedVoxels& voxels,
                const fs::path& path) {
  if (series.size() > std::numeric_limits<std::int16_t>::max())
    throw Error(ErrorCode::InvalidArgument,
                "NIfTI holds at most 32767 frames; write " + quoted(path) + " as .seq.nrrd.");
  writeAtomically(path, [&](const fs::path& temporary) {
    fs::path scratch = temporary;
    scratch.replace_extension(); // ".nii" from ".nii.gz"
    scratch += "-header.nii";
    const std::string header = niftiHeader(series, interval, type, scratch);
    const bool compressed = fullExtension(path) == ".nii.gz";
    writeBehind(header, voxels.data(), voxels.bytes(), compressed ? "wb" : "wbT", temporary,
                writingFailed(path));
  });
}

nlohmann::json existingSidecar(const fs::path& path) {
  std::ifstream in(sidecarOf(path), std::ios::binary);
  nlohmann::json values = in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
  return values.is_object() ? values : nlohmann::json::object();
}

double meanInterval(const std::vector<double>& times) {
  return times.size() > 1 ? (times.back() - times.front()) / static_cast<double>(times.size() - 1) : 1;
}

} // namespace

/// NIfTI's header holds the first time and the interval in single precision.
bool needsSidecar(const fs::path& path, const std::vector<double>& times) {
  if (!isNifti(path)) return false;
  const double interval = meanInterval(times);
  for (std::size_t f = 0; f < times.size(); ++f)
    if (std::abs(times[f] - times.front() - interval * static_cast<double>(f)) >
        1e-6 * std::max(1.0, interval))
      return true;
  return false;
}

void checkTimeSeriesPath(const fs::path& path) {
  if (!isNifti(path) && !isSequenceFile(path))
    throw Error(ErrorCode::InvalidArgument,
                quoted(path) + " has no extension of a dynamic scan; use .nii.gz, .nii or .seq.nrrd.");
  checkOutputFolder(path);
}

std::string writeTimeSeries(const TimeSeries& series, const fs::path& path, OutputType type,
                            const std::optional<VoxelValues>& expected) {
  checkTimeSeriesPath(path);
  checkGeometry(series.geometry, "The series for " + quoted(path));
  const auto count = static_cast<std::size_t>(series.geometry.voxelCount());
  std::vector<float> all;
  all.reserve(count * series.frames.size());
  for (const auto& frame : series.frames) {
    if (frame.size() != count)
      throw Error(ErrorCode::InvalidArgument,
                  "The series for " + quoted(path) + " has a frame with fewer or more voxels than its grid.");
    all.insert(all.end(), frame.begin(), frame.end());
  }
  if (series.frames.empty() || series.times.size() != series.frames.size())
    throw Error(ErrorCode::InvalidArgument,
                "The series for " + quoted(path) + " needs frames, with one time each.");
  const TypedVoxels voxels(all, type, expected, path);
  if (isSequenceFile(path)) {
    writeSequence(series, type, voxels, path);
    return voxels.remark();
  }
  const double interval = meanInterval(series.times);
  writeNifti(series, interval, type, voxels, path);
  nlohmann::json sidecar = existingSidecar(path); // its times would override the header's
  if (needsSidecar(path, series.times) || sidecar.contains("VolumeTiming")) {
    sidecar["VolumeTiming"] = series.times;
    writeFileAtomically(sidecarOf(path), sidecar.dump(1) + "\n");
  }
  return voxels.remark();
}

} // namespace innergs
