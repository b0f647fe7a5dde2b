#include "IO/NiftiFile.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "IO/ItkImage.h"

#include <itk_zlib.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace fs = std::filesystem;

namespace innergs {
namespace {

constexpr std::size_t headerBytes = 348;

/// zlib also reads uncompressed files.
using GzFile = std::unique_ptr<gzFile_s, int (*)(gzFile)>;
GzFile openGz(const fs::path& path) {
  return {gzopen(utf8(path).c_str(), "rb"), gzclose};
}

template <typename T>
T swapBytes(T value) {
  std::array<unsigned char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  std::reverse(bytes.begin(), bytes.end());
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

class Fields {
public:
  Fields(const std::array<unsigned char, headerBytes>& bytes, bool swapped)
      : bytes_(bytes), swapped_(swapped) {}
  template <typename T>
  T get(std::size_t offset) const {
    T value;
    std::memcpy(&value, bytes_.data() + offset, sizeof(T));
    return swapped_ ? swapBytes(value) : value;
  }

private:
  const std::array<unsigned char, headerBytes>& bytes_;
  bool swapped_;
};

fs::path voxelFileOf(const fs::path& path, bool pair) {
  if (!pair) return path;
  fs::path image = path;
  if (fullExtension(path) == ".hdr.gz") image.replace_extension();
  image.replace_extension(".img");
  std::error_code ignored;
  if (fs::exists(image, ignored)) return image;
  image += ".gz";
  if (fs::exists(image, ignored)) return image;
  throw Error(ErrorCode::FileNotFound,
              quoted(path) + " has no .img file beside it; copy both files of the pair.");
}

/// ITK aborts the process if a matrix contains NaN.
void checkFinite(const NiftiHeader& header, const Vec3& quaternion, const std::string& what) {
  bool sound = header.qformCode <= 0 || (isFinite(header.qformOffset) && isFinite(quaternion));
  if (header.sformCode > 0) {
    sound = sound && isFinite(header.sform.offset);
    for (int row = 0; row < 3; ++row)
      sound = sound && isFinite(header.sform.linear[row]);
  }
  if (!sound)
    throw Error(ErrorCode::Geometry,
                what + " has an orientation or origin that is not finite; correct its header.");
}

/// ITK falls back on the qform if the sform is sheared, which is right only if the sform is a registration to
/// a template.
void checkNotSheared(const NiftiHeader& header, const std::string& what) {
  constexpr int talairach = 3;
  if (header.sformCode <= 0 || (header.sformCode >= talairach && header.qformCode > 0)) return;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) {
      const Vec3 a = column(header.sform.linear, i), b = column(header.sform.linear, j);
      const double cosine = dot(a, b) / (norm(a) * norm(b));
      if (!(std::abs(cosine) <= 1e-3))
        throw Error(ErrorCode::Geometry, what +
                                             " has a sheared or singular orientation (its sform axes are not "
                                             "perpendicular); resample it to a rectangular grid first.");
    }
}

template <typename T>
void convert(const std::vector<unsigned char>& bytes, const NiftiHeader& header, float* out,
             std::size_t count) {
  const bool scaled = header.slope != 1 || header.intercept != 0;
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    if (header.swapped) value = swapBytes(value);
    out[i] = scaled ? static_cast<float>(header.slope * static_cast<double>(value) + header.intercept)
                    : static_cast<float>(value);
  }
}

/// How voxels of one NIfTI datatype are read.
struct VoxelType {
  int datatype, bytes;
  void (*convert)(const std::vector<unsigned char>& bytes, const NiftiHeader& header, float* out,
                  std::size_t count);
};

template <typename T>
constexpr VoxelType voxelType(int datatype) {
  return {datatype, sizeof(T), convert<T>};
}

constexpr std::array voxelTypes{voxelType<std::uint8_t>(2),    voxelType<std::int16_t>(4),
                                voxelType<std::int32_t>(8),    voxelType<float>(16),
                                voxelType<double>(64),         voxelType<std::int8_t>(256),
                                voxelType<std::uint16_t>(512), voxelType<std::uint32_t>(768),
                                voxelType<std::int64_t>(1024), voxelType<std::uint64_t>(1280)};

/// Null for other types, of which colour and complex are rejected later, by ITK's pixel type.
const VoxelType* voxelTypeOf(int datatype) {
  const auto found = std::find_if(voxelTypes.begin(), voxelTypes.end(),
                                  [&](const VoxelType& type) { return type.datatype == datatype; });
  return found == voxelTypes.end() ? nullptr : &*found;
}

/// Rejected later, by ITK's pixel type.
bool isColourOrComplex(int datatype) {
  return datatype == 128 || datatype == 2304 || datatype == 32 || datatype == 1792;
}

/// NIfTI's slice_code: the order in which slices first to last were acquired; {} for any other code.
std::vector<std::int64_t> sliceOrder(int code, std::int64_t first, std::int64_t last) {
  std::vector<std::int64_t> order;
  const auto every = [&](std::int64_t from, std::int64_t step) {
    for (std::int64_t s = from; s <= last; s += step)
      order.push_back(s);
  };
  if (code == 1 || code == 2) every(first, 1);
  if (code == 3 || code == 4) every(first, 2), every(first + 1, 2);
  if (code == 5 || code == 6) every(first + 1, 2), every(first, 2);
  if (code == 2 || code == 4 || code == 6) // from the last one on
    for (std::int64_t& s : order)
      s = first + last - s;
  return order;
}

/// Acquisition time of each slice, s after the frame's start; empty if the header leaves something out.
std::vector<double> sliceTimes(const Fields& fields, std::int64_t slices, double second) {
  const std::int64_t first = fields.get<std::int16_t>(74);
  std::int64_t last = fields.get<std::int16_t>(120);
  if (last == 0) last = slices - 1; // many writers leave it out
  const double duration = second * static_cast<double>(fields.get<float>(132));
  if (!(duration > 0) || !std::isfinite(duration) || first < 0 || last >= slices || first > last) return {};
  const auto order = sliceOrder(fields.get<signed char>(122), first, last);
  if (order.empty()) return {};
  std::vector<double> times(static_cast<std::size_t>(slices), 0.0); // slices beyond are padding
  for (std::size_t n = 0; n < order.size(); ++n)
    times[static_cast<std::size_t>(order[n])] = duration * static_cast<double>(n);
  return times;
}

/// Seconds per unit of the fourth axis; 0 if it is not time.
double secondsPerUnit(unsigned char units) {
  const int time = units & 0x38;
  return time == 8 ? 1 : time == 16 ? 1e-3 : time == 24 ? 1e-6 : 0;
}

} // namespace

NiftiHeader readNiftiHeader(const fs::path& path) {
  const std::string what = quoted(path);
  std::array<unsigned char, headerBytes> bytes{};
  {
    const GzFile file = openGz(path);
    if (!file || gzread(file.get(), bytes.data(), headerBytes) != static_cast<int>(headerBytes))
      throw Error(ErrorCode::FileFormat,
                  what + " is not a NIfTI image or is truncated; copy or export it again.");
  }
  NiftiHeader header;
  std::int32_t headerSize;
  std::memcpy(&headerSize, bytes.data(), 4);
  header.swapped = headerSize != 348 && headerSize != 540;
  const Fields fields(bytes, header.swapped);
  headerSize = fields.get<std::int32_t>(0);
  if (headerSize == 540)
    throw Error(ErrorCode::UnsupportedImage,
                what + " is a NIfTI-2 file, which cannot be read; convert it to NIfTI-1.");
  const std::string magic(reinterpret_cast<const char*>(bytes.data()) + 344, 3);
  if (headerSize == 348 && magic != "n+1" && magic != "ni1")
    throw Error(ErrorCode::UnsupportedImage,
                what + " is an Analyze 7.5 image without a defined orientation; convert it to NIfTI.");
  const int dimensions = fields.get<std::int16_t>(40);
  if (headerSize != 348 || dimensions < 1 || dimensions > 7)
    throw Error(ErrorCode::FileFormat,
                what + " is not a NIfTI image or is damaged; copy or export it again.");

  header.voxelFile = voxelFileOf(path, magic == "ni1");
  for (int axis = 0; axis < dimensions; ++axis) {
    header.size[axis] = fields.get<std::int16_t>(42 + 2 * axis);
    if (header.size[axis] < 1)
      throw Error(ErrorCode::FileFormat, what + " has an axis without voxels; it is damaged.");
  }
  for (int axis = 0; axis < 3; ++axis) {
    header.spacing[axis] = fields.get<float>(80 + 4 * axis);
    if (axis < dimensions && !(std::isfinite(header.spacing[axis]) && header.spacing[axis] > 0))
      throw Error(ErrorCode::Geometry,
                  what +
                      " has a voxel spacing that is not finite and above zero; correct its header (pixdim).");
  }
  const double second = secondsPerUnit(bytes[123]), between = fields.get<float>(92);
  if (dimensions > 3 && std::isfinite(between) && between > 0) header.frameSeconds = second * between;
  if (const double offset = fields.get<float>(136); std::isfinite(offset))
    header.firstSeconds = second * offset;
  if (const int axis = (bytes[39] >> 4 & 3) - 1; axis >= 0 && axis < std::min(dimensions, 3)) {
    header.sliceAxis = axis;
    header.sliceSeconds = sliceTimes(fields, header.size[axis], second);
  }
  header.intent = fields.get<std::int16_t>(68);
  header.datatype = fields.get<std::int16_t>(70);
  if (const VoxelType* const type = voxelTypeOf(header.datatype))
    header.bytesPerVoxel = type->bytes;
  else if (!isColourOrComplex(header.datatype))
    throw Error(
        ErrorCode::UnsupportedImage,
        what +
            " has a voxel type that cannot be read; convert it to a common integer or floating-point type.");
  const float offset = fields.get<float>(108);
  header.voxelOffset = magic == "n+1" ? std::int64_t{352} : 0;
  if (std::isfinite(offset) && offset > static_cast<float>(header.voxelOffset) && offset < 1e15f)
    header.voxelOffset = static_cast<std::int64_t>(offset);
  const float slope = fields.get<float>(112), intercept = fields.get<float>(116);
  if (std::isfinite(slope) && slope != 0) {
    header.slope = slope;
    header.intercept = std::isfinite(intercept) ? intercept : 0;
  }
  const int lengthUnit = bytes[123] & 7;
  header.millimetres = lengthUnit == 1 ? 1e3 : lengthUnit == 3 ? 1e-3 : 1;
  header.qformCode = fields.get<std::int16_t>(252);
  header.sformCode = fields.get<std::int16_t>(254);
  for (int row = 0; row < 3; ++row) {
    header.qformOffset[row] = fields.get<float>(268 + 4 * row);
    for (int axis = 0; axis < 3; ++axis)
      header.sform.linear[row][axis] = fields.get<float>(280 + 16 * row + 4 * axis);
    header.sform.offset[row] = fields.get<float>(292 + 16 * row);
  }
  checkFinite(header, {fields.get<float>(256), fields.get<float>(260), fields.get<float>(264)}, what);
  checkNotSheared(header, what);
  return header;
}

Vec3 originInMillimetres(const NiftiHeader& header, const Vec3& origin) {
  if (header.millimetres == 1) return origin;
  const Vec3 ras{-origin[0], -origin[1], origin[2]};
  const double tolerance = 1e-5 * (1 + norm(ras));
  const bool unscaled =
      norm(ras - header.sform.offset) <= tolerance || norm(ras - header.qformOffset) <= tolerance;
  return unscaled ? header.millimetres * origin : origin;
}

std::vector<std::vector<float>> readNiftiFrames(const NiftiHeader& header, std::int64_t first,
                                                std::int64_t count, const fs::path& path) {
  const auto truncated = [&] {
    return Error(ErrorCode::FileFormat, quoted(path) + " is truncated or damaged; copy or export it again.");
  };
  const double perFrame = double(header.size[0]) * double(header.size[1]) * double(header.size[2]);
  const double needed = header.voxelOffset + perFrame * double(first + count) * header.bytesPerVoxel;
  constexpr double largestDeflateRatio = 1032;
  if (needed > largestDeflateRatio * double(checkInputFile(header.voxelFile)) + 4096) throw truncated();
  checkMemoryFor(perFrame * double(count) * sizeof(float), quoted(path));

  const GzFile file = openGz(header.voxelFile);
  if (!file) throw truncated();
  const auto voxels = static_cast<std::int64_t>(perFrame);
  const std::int64_t start = header.voxelOffset + first * voxels * header.bytesPerVoxel;
  if (gzseek(file.get(), static_cast<z_off_t>(start), SEEK_SET) < 0) throw truncated();
  constexpr std::int64_t chunk = 1 << 16;
  const VoxelType* const type = voxelTypeOf(header.datatype);
  std::vector<unsigned char> bytes(static_cast<std::size_t>(chunk * header.bytesPerVoxel));
  std::vector<std::vector<float>> frames(static_cast<std::size_t>(count));
  for (auto& frame : frames) {
    frame.resize(static_cast<std::size_t>(voxels));
    for (std::int64_t done = 0; done < voxels; done += chunk) {
      const std::int64_t n = std::min(chunk, voxels - done);
      const int wanted = static_cast<int>(n * header.bytesPerVoxel);
      if (gzread(file.get(), bytes.data(), static_cast<unsigned>(wanted)) != wanted) throw truncated();
      if (type) type->convert(bytes, header, frame.data() + done, static_cast<std::size_t>(n));
    }
  }
  return frames;
}

} // namespace innergs
