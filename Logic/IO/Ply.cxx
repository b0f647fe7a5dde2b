#include "IO/Ply.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Image/Bounds.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/MemoryCheck.h"
#include "IO/PlyHeader.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <locale>
#include <sstream>
#include <string_view>

namespace innergs {
namespace {

/// 3DGS stores colour as the constant spherical harmonic, offset by 0.5.
constexpr double sphericalHarmonic0 = 0.28209479177387814;

constexpr std::array names{"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                           "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
                           // The exact values in the model frame.
                           "innergs_x", "innergs_y", "innergs_z", "innergs_rot_0", "innergs_rot_1",
                           "innergs_rot_2", "innergs_rot_3", "innergs_log_weight", "innergs_intensity",
                           "innergs_slope_0", "innergs_slope_1", "innergs_slope_2"};
constexpr std::size_t firstOwn = 17;
using Row = std::array<float, names.size()>;
static_assert(sizeof(Row) == names.size() * sizeof(float));

using Quaternion = std::array<double, 4>; // w, x, y, z

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

/// The quaternion of a rotation; uses the branch with the largest divisor to avoid cancellation.
Quaternion quaternionOf(const Mat3& r) {
  const std::array<double, 4> squares{1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
                                      1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
  const auto largest = std::max_element(squares.begin(), squares.end());
  const double d = 2 * std::sqrt(*largest);
  switch (largest - squares.begin()) {
  case 0:
    return {d / 4, (r[2][1] - r[1][2]) / d, (r[0][2] - r[2][0]) / d, (r[1][0] - r[0][1]) / d};
  case 1:
    return {(r[2][1] - r[1][2]) / d, d / 4, (r[0][1] + r[1][0]) / d, (r[0][2] + r[2][0]) / d};
  case 2:
    return {(r[0][2] - r[2][0]) / d, (r[0][1] + r[1][0]) / d, d / 4, (r[1][2] + r[2][1]) / d};
  default:
    return {(r[1][0] - r[0][1]) / d, (r[0][2] + r[2][0]) / d, (r[1][2] + r[2][1]) / d, d / 4};
  }
}

/// The weight as a 3DGS opacity: a logit, so weights of 1 and more are clipped just below 1.
double opacityLogit(Blending blending, double logWeight) {
  if (blending == Blending::Alpha) return logWeight; // is a logit already
  const double opacity = std::clamp(std::exp(logWeight), 1e-7, 1 - 1e-6);
  return std::log(opacity / (1 - opacity));
}

Row rowOf(const Gaussian& g, Blending blending, const Affine3& modelToWorld, const Quaternion& rotation) {
  const Vec3 position = modelToWorld({g.mean[0], g.mean[1], g.mean[2]});
  const Quaternion q =
      product(rotation, {g.quaternion[0], g.quaternion[1], g.quaternion[2], g.quaternion[3]});
  const auto colour = static_cast<float>((g.intensity - 0.5) / sphericalHarmonic0);
  const auto f = [](double value) { return static_cast<float>(value); };
  return {f(position[0]),
          f(position[1]),
          f(position[2]),
          0,
          0,
          0,
          colour,
          colour,
          colour,
          f(opacityLogit(blending, g.logWeight)),
          g.logScale[0],
          g.logScale[1],
          g.logScale[2],
          f(q[0]),
          f(q[1]),
          f(q[2]),
          f(q[3]),
          g.mean[0],
          g.mean[1],
          g.mean[2],
          g.quaternion[0],
          g.quaternion[1],
          g.quaternion[2],
          g.quaternion[3],
          g.logWeight,
          g.intensity,
          g.slope[0],
          g.slope[1],
          g.slope[2]};
}

std::string number(double value) {
  return formatted("%.17g", value);
}
template <typename... Rows>
std::string numbers(const Rows&... rows) {
  std::string text;
  const auto add = [&](const auto& row) {
    for (const auto value : row) {
      if (!text.empty()) text += ' ';
      text += number(static_cast<double>(value));
    }
  };
  (add(rows), ...);
  return text;
}

std::string headerOf(const GaussianField& field) {
  const Mat3& r = field.modelToWorld.linear;
  const GridGeometry& d = field.domain;
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  const auto comment = [&](const char* key, const std::string& value) {
    text += std::string("comment innergs ") + key + " " + value + "\n";
  };
  comment("format_version", "1");
  comment("blending", blendingName(field.blending));
  comment("linear_intensity", field.linearIntensity ? "1" : "0");
  comment("epsilon", number(field.epsilon));
  comment("cutoff", number(field.cutoff));
  comment("model_to_world_linear", numbers(r[0], r[1], r[2]));
  comment("model_to_world_offset", numbers(field.modelToWorld.offset));
  comment("intensity_scale", number(field.intensityScale));
  comment("intensity_offset", number(field.intensityOffset));
  comment("domain_size", numbers(d.size));
  comment("domain_origin", numbers(d.origin));
  comment("domain_spacing", numbers(d.spacing));
  comment("domain_direction", numbers(d.direction[0], d.direction[1], d.direction[2]));
  if (field.range) comment("value_range", numbers(std::array{field.range->low, field.range->high}));
  text += "element vertex " + std::to_string(field.size()) + "\n";
  for (const char* name : names)
    text += std::string("property float ") + name + "\n";
  return text + "end_header\n";
}

[[noreturn]] void failComment(const std::filesystem::path& path, const std::string& key) {
  throw Error(ErrorCode::FileFormat, quoted(path) + " is damaged (its comment 'innergs " + key +
                                         "' is missing or wrong); export it again.");
}

template <std::size_t n>
std::array<double, n> commentNumbers(const PlyHeader& header, const std::string& key,
                                     const std::filesystem::path& path) {
  const auto found = header.comments.find(key);
  if (found == header.comments.end()) failComment(path, key);
  std::istringstream words(found->second);
  words.imbue(std::locale::classic());
  std::array<double, n> values;
  for (double& value : values)
    if (!(words >> value) || !std::isfinite(value)) failComment(path, key);
  return values;
}

Mat3 matrixOf(const std::array<double, 9>& v) {
  return {{{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}}}};
}

void readOwnComments(const PlyHeader& header, const std::filesystem::path& path, GaussianField& field) {
  const auto one = [&](const char* key) { return commentNumbers<1>(header, key, path)[0]; };
  if (one("format_version") > 1)
    throw Error(ErrorCode::FileFormat,
                quoted(path) + " was written by a newer version of InnerGS; update InnerGS to open it.");
  const auto named = header.comments.find("blending");
  const auto blending = named == header.comments.end() ? std::nullopt : blendingNamed(named->second);
  if (!blending) failComment(path, "blending");
  field.blending = *blending;
  field.linearIntensity = one("linear_intensity") != 0;
  field.epsilon = one("epsilon");
  field.cutoff = one("cutoff");
  field.modelToWorld.linear = matrixOf(commentNumbers<9>(header, "model_to_world_linear", path));
  field.modelToWorld.offset = commentNumbers<3>(header, "model_to_world_offset", path);
  field.intensityScale = one("intensity_scale");
  field.intensityOffset = one("intensity_offset");
  const std::array<double, 3> size = commentNumbers<3>(header, "domain_size", path);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(size[axis] >= 0 && size[axis] <= double(1 << 30))) failComment(path, "domain_size");
    field.domain.size[axis] = static_cast<std::int64_t>(size[axis]);
  }
  field.domain.origin = commentNumbers<3>(header, "domain_origin", path);
  field.domain.spacing = commentNumbers<3>(header, "domain_spacing", path);
  field.domain.direction = matrixOf(commentNumbers<9>(header, "domain_direction", path));
  if (header.comments.contains("value_range")) {
    const auto range = commentNumbers<2>(header, "value_range", path);
    field.range = {static_cast<float>(range[0]), static_cast<float>(range[1])};
  }
  try {
    checkGeometry(field.domain, "the domain");
  } catch (const Error&) {
    failComment(path, "domain");
  }
}

/// A grid around the Gaussians of a file without a domain: 256 voxels along the longest side.
GridGeometry domainAround(const std::vector<Gaussian>& gaussians) {
  Bounds bounds;
  for (const Gaussian& g : gaussians)
    bounds.include({g.mean[0], g.mean[1], g.mean[2]});
  const double longest = bounds.longestSide();
  const double spacing = std::isfinite(longest) && longest > 0 ? longest / 255 : 1;
  GridGeometry domain;
  domain.origin = bounds.low;
  domain.spacing = {spacing, spacing, spacing};
  for (int axis = 0; axis < 3; ++axis)
    domain.size[axis] =
        std::clamp<std::int64_t>(std::llround((bounds.high[axis] - bounds.low[axis]) / spacing) + 1, 1, 256);
  return domain;
}

/// Reads named properties, vertex by vertex.
class Vertices {
public:
  Vertices(const PlyHeader& header, const std::filesystem::path& path)
      : header_(header), path_(path), in_(path, std::ios::binary), vertex_(header.vertexBytes) {
    in_.seekg(static_cast<std::streamoff>(header.dataStart));
  }
  void next() {
    if (!in_.read(vertex_.data(), static_cast<std::streamsize>(vertex_.size())))
      throw Error(ErrorCode::FileFormat, quoted(path_) + " is cut off; export it again.");
  }
  std::vector<PlyHeader::Property> find(std::size_t first, std::size_t last) const {
    std::vector<PlyHeader::Property> found;
    for (std::size_t i = first; i < last; ++i) {
      const auto property = header_.properties.find(names[i]);
      if (property == header_.properties.end())
        throw Error(ErrorCode::FileFormat, quoted(path_) +
                                               " is not a PLY file of Gaussians (the vertex property '" +
                                               names[i] + "' is missing); choose another file.");
      found.push_back(property->second);
    }
    return found;
  }
  double value(const PlyHeader::Property& property) const { return plyValue(property, vertex_.data()); }

private:
  const PlyHeader& header_;
  const std::filesystem::path& path_;
  std::ifstream in_;
  std::vector<char> vertex_;
};

/// Reads InnerGS's additional properties.
void readOwn(Vertices& vertices, std::vector<Gaussian>& gaussians) {
  const auto scale = vertices.find(10, 13), own = vertices.find(firstOwn, names.size());
  for (Gaussian& g : gaussians) {
    vertices.next();
    const auto value = [&](std::size_t i) { return static_cast<float>(vertices.value(own[i])); };
    for (std::size_t i = 0; i < 3; ++i) {
      g.mean[i] = value(i);
      g.logScale[i] = static_cast<float>(vertices.value(scale[i]));
      g.slope[i] = value(9 + i);
    }
    for (std::size_t i = 0; i < 4; ++i)
      g.quaternion[i] = value(3 + i);
    g.logWeight = value(7);
    g.intensity = value(8);
  }
}

/// Plain 3DGS: opacity becomes the weight, the grey value of the constant colour the intensity.
void readPlain(Vertices& vertices, std::vector<Gaussian>& gaussians) {
  const auto position = vertices.find(0, 3), shape = vertices.find(6, firstOwn);
  for (Gaussian& g : gaussians) {
    vertices.next();
    const auto value = [&](std::size_t i) { return vertices.value(shape[i]); };
    for (std::size_t i = 0; i < 3; ++i) {
      g.mean[i] = static_cast<float>(vertices.value(position[i]));
      g.logScale[i] = static_cast<float>(value(4 + i));
    }
    for (std::size_t i = 0; i < 4; ++i)
      g.quaternion[i] = static_cast<float>(value(7 + i));
    g.logWeight = static_cast<float>(-std::log1p(std::exp(-value(3)))); // ln sigmoid
    g.intensity = static_cast<float>(0.5 + sphericalHarmonic0 * (value(0) + value(1) + value(2)) / 3);
  }
}

} // namespace

void writePly(const GaussianField& field, const std::filesystem::path& path) {
  const Quaternion rotation = quaternionOf(field.modelToWorld.linear);
  writeAtomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    const std::string header = headerOf(field);
    out.write(header.data(), static_cast<std::streamsize>(header.size()));
    for (const Gaussian& gaussian : field.gaussians) {
      const Row row = rowOf(gaussian, field.blending, field.modelToWorld, rotation);
      out.write(reinterpret_cast<const char*>(row.data()), sizeof(row));
    }
    out.close();
    if (!out)
      throw Error(ErrorCode::Io, quoted(path) +
                                     " could not be written (the disk is full or failed); free some space or "
                                     "choose another folder.");
  });
}

namespace {

/// " the residual grid of 2x3x4 values (RMS 2.5 scanner units)"
std::string detailText(const GaussianField& field) {
  double squares = 0;
  for (const float value : field.residual.voxels)
    squares += double(value) * value;
  const double rms =
      std::abs(field.intensityScale) * std::sqrt(squares / static_cast<double>(field.residual.voxels.size()));
  const auto& size = field.residual.geometry.size;
  return " the residual grid of " + std::to_string(size[0]) + "x" + std::to_string(size[1]) + "x" +
         std::to_string(size[2]) + " values (RMS " + numberText(rms) + " scanner units)";
}

} // namespace

std::string droppedByPly(const GaussianField& field, int segments) {
  const Volume& residual = field.residual;
  const auto& support = field.support.voxels;
  if (residual.voxels.empty() && support.empty() && segments == 0) return {};
  std::string left;
  if (!support.empty())
    left = " the mask of " + countText(std::count(support.begin(), support.end(), 1)) +
           " voxels, beyond which the Gaussians reach";
  if (!residual.voxels.empty()) left += (left.empty() ? "" : ", and") + detailText(field);
  if (segments > 0)
    left += (left.empty() ? "" : ", and") + std::string(" what was learned about ") + countText(segments) +
            (segments == 1 ? " segment" : " segments");
  return "A PLY file holds the " + countText(field.size()) + " Gaussians alone: it leaves out" + left +
         "; save an .innergs file to keep everything.";
}

bool isPly(const std::filesystem::path& path) {
  if (fullExtension(path) == ".ply") return true;
  char start[4] = {};
  std::ifstream(path, std::ios::binary).read(start, sizeof(start));
  const std::string_view magic(start, sizeof(start));
  return magic == "ply\n" || magic == "ply\r";
}

GaussianField readPly(const std::filesystem::path& path) {
  const PlyHeader header = readPlyHeader(path);
  checkMemoryFor(double(header.vertices) * sizeof(Gaussian), quoted(path));
  GaussianField field;
  field.gaussians.assign(static_cast<std::size_t>(header.vertices), Gaussian{});
  Vertices vertices(header, path);
  if (header.comments.contains("format_version")) {
    readOwnComments(header, path, field);
    readOwn(vertices, field.gaussians);
  } else {
    readPlain(vertices, field.gaussians);
    if (!field.gaussians.empty()) field.domain = domainAround(field.gaussians);
  }
  checkField(field);
  return field;
}

} // namespace innergs
