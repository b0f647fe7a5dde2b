#include "IO/TrackedSweep.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/FilePath.h"
#include "IO/ItkImage.h"

#include <itkXMLFile.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>

namespace innergs {
namespace {

using SweepFields = std::map<std::string, std::string>;

/// Sixteen numbers, row by row, as an affine map; nothing if they are no such map.
std::optional<Affine3> affineFrom(const std::string& text) {
  std::vector<double> values;
  std::size_t length = 0;
  for (std::string rest = text; rest.find_first_not_of(" \t\r\n") != std::string::npos;
       rest.erase(0, length)) {
    const auto value = leadingNumber(rest, &length);
    if (!value || length == 0 || !std::isfinite(*value) || values.size() == 16) return {};
    values.push_back(*value);
  }
  if (values.size() != 16) return {};
  Affine3 map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      map.linear.m[row][column] = values[4 * row + column];
    map.offset[row] = values[4 * row + 3];
  }
  const bool affine = std::abs(values[12]) + std::abs(values[13]) + std::abs(values[14]) < 1e-6 &&
                      std::abs(values[15] - 1) < 1e-6;
  if (!affine || !(std::abs(determinant(map.linear)) > 1e-12)) return {};
  return map;
}

/// Collects the elements <Transform From="Image" To="Probe" Matrix="..."/>.
class ConfigurationReader : public itk::XMLReader<NamedTransforms> {
public:
  using Self = ConfigurationReader;
  using Pointer = itk::SmartPointer<Self>;
  itkNewMacro(Self);
  int CanReadFile(const char* /*name*/) override { return 1; }
  NamedTransforms transforms;
  std::string damaged; // the name of one whose matrix is none

protected:
  void StartElement(const char* name, const char** attributes) override {
    if (std::string(name) != "Transform") return;
    std::map<std::string, std::string> given;
    for (; attributes[0] && attributes[1]; attributes += 2)
      given[attributes[0]] = attributes[1];
    if (!given.contains("From") || !given.contains("To") || !given.contains("Matrix")) return;
    const std::string transform = given["From"] + "To" + given["To"];
    if (const auto map = affineFrom(given["Matrix"]))
      transforms[transform] = *map;
    else
      damaged = transform;
  }
  void EndElement(const char* /*name*/) override {}
  void CharacterDataHandler(const char* /*text*/, int /*length*/) override {}
};

/// "ImageToProbe" as "Image" and "Probe".
std::optional<std::pair<std::string, std::string>> endsOf(const std::string& transform) {
  for (std::size_t at = transform.find("To", 1); at != std::string::npos; at = transform.find("To", at + 1))
    if (at + 2 < transform.size() && std::isupper(static_cast<unsigned char>(transform[at + 2])))
      return std::pair(transform.substr(0, at), transform.substr(at + 2));
  return {};
}

struct SweepFrame {
  std::map<std::string, std::string> transforms, fields; // by name without "Transform"
};

/// What the header says of each image, and of all.
std::vector<SweepFrame> framesOf(const SweepFields& fields, std::size_t count, SweepFrame& all) {
  std::vector<SweepFrame> frames(count);
  const std::string prefix = "Seq_Frame", suffix = "Transform";
  for (const auto& [key, value] : fields) {
    SweepFrame* frame = &all;
    std::string name = key;
    if (key.starts_with(prefix)) {
      std::size_t n = count;
      const char* first = key.data() + prefix.size();
      const auto [end, error] = std::from_chars(first, key.data() + key.size(), n);
      if (error != std::errc{} || n >= count || end == key.data() + key.size() || *end != '_') continue;
      frame = &frames[n];
      name = std::string(end + 1);
    }
    if (name.ends_with(suffix))
      frame->transforms[name.substr(0, name.size() - suffix.size())] = value;
    else
      frame->fields[name] = value;
  }
  return frames;
}

/// A step of the way from the pixels to the reference.
struct Step {
  std::string transform;
  bool inverted = false;
};

/// The shortest way between two systems; nothing if there is none.
std::optional<std::vector<Step>> way(const std::set<std::string>& transforms, const std::string& from,
                                     const std::string& to) {
  std::map<std::string, std::vector<Step>> reached{{from, {}}};
  std::vector<std::string> toDo{from};
  for (std::size_t n = 0; n < toDo.size(); ++n) {
    const std::string at = toDo[n];
    if (at == to) return reached[at];
    for (const std::string& transform : transforms) {
      const auto ends = endsOf(transform);
      if (!ends || (ends->first != at && ends->second != at)) continue;
      const bool inverted = ends->second == at;
      const std::string& next = inverted ? ends->first : ends->second;
      if (reached.contains(next)) continue;
      reached[next] = reached[at];
      reached[next].push_back({transform, inverted});
      toDo.push_back(next);
    }
  }
  return {};
}

constexpr std::array kReferences{"Reference", "Patient", "World", "RAS", "Tracker"};

std::optional<std::vector<Step>> wayToReference(const SweepFields& fields,
                                                const NamedTransforms& calibration) {
  std::set<std::string> names;
  for (const auto& [name, map] : calibration)
    names.insert(name);
  for (const auto& [key, value] : fields) {
    if (!key.ends_with("Transform")) continue;
    std::string name = key.substr(0, key.size() - std::string("Transform").size());
    if (key.starts_with("Seq_Frame")) name = name.substr(std::min(name.find('_', 9), name.size() - 1) + 1);
    names.insert(name);
  }
  for (const char* reference : kReferences)
    if (auto steps = way(names, "Image", reference)) return steps;
  return {};
}

/// From the pixels to the reference, where both were tracked.
std::optional<Affine3> placeOf(const SweepFrame& frame, const SweepFrame& all, const std::vector<Step>& steps,
                               const NamedTransforms& calibration, const std::string& what) {
  const auto isValid = [&](const std::string& name) {
    const auto status = frame.fields.find(name + "Status");
    return status == frame.fields.end() || status->second == "OK";
  };
  if (!isValid("Image")) return {};
  Affine3 place;
  for (const auto& [transform, inverted] : steps) {
    const auto known = calibration.find(transform);
    std::optional<Affine3> map;
    if (known != calibration.end()) {
      map = known->second;
    } else {
      const auto own = frame.transforms.find(transform), common = all.transforms.find(transform);
      if (!isValid(transform + "Transform") ||
          (own == frame.transforms.end() && common == all.transforms.end()))
        return {};
      map = affineFrom(own != frame.transforms.end() ? own->second : common->second);
      if (!map)
        throw Error(ErrorCode::FileFormat, what + " has a transform " + transform +
                                               " that is no affine map of 16 numbers; export it again.");
    }
    place = (inverted ? inverse(*map) : *map) * place;
  }
  return place;
}

/// Turns the images so that columns run towards the marked side and rows away from the probe, as the system
/// Image is defined: "MF". U: unmarked, N: near.
void orient(Volume& images, const std::string& orientation, const std::string& what) {
  if (orientation.empty() || orientation == "XX") return;
  const bool known = (orientation.size() == 2 || orientation.size() == 3) &&
                     (orientation[0] == 'M' || orientation[0] == 'U') &&
                     (orientation[1] == 'F' || orientation[1] == 'N') &&
                     (orientation.size() == 2 || orientation[2] == 'A');
  if (!known)
    throw Error(ErrorCode::UnsupportedImage, what + " has images in the orientation " + orientation +
                                                 "; export them as MF, UF, MN or UN.");
  const auto& size = images.geometry.size;
  const auto row = static_cast<std::ptrdiff_t>(size[0]), rows = static_cast<std::ptrdiff_t>(size[1]);
  for (std::int64_t k = 0; k < size[2]; ++k) {
    const auto image = images.voxels.begin() + k * row * rows;
    if (orientation[0] == 'U')
      for (std::ptrdiff_t j = 0; j < rows; ++j)
        std::reverse(image + j * row, image + (j + 1) * row);
    if (orientation[1] == 'N')
      for (std::ptrdiff_t j = 0; j < rows / 2; ++j)
        std::swap_ranges(image + j * row, image + (j + 1) * row, image + (rows - 1 - j) * row);
  }
}

/// Where an image lies: LPS mm.
struct Placed {
  std::size_t frame = 0;
  Vec3 corner, right, down;              // first pixel; unit vectors, perpendicular
  double pixel = 0, line = 0, shear = 0; // mm, mm along the columns, cosine between rows and columns
};

Placed placed(const Affine3& place, std::size_t frame) {
  const Mat3 toLps = diagonal({-1, -1, 1});
  const Mat3 linear = toLps * place.linear;
  const Vec3 i = column(linear, 0), j = column(linear, 1);
  Placed p{frame, toLps * place.offset, (1 / norm(i)) * i, {}, norm(i), norm(j), 0};
  p.shear = dot(p.right, j) / p.line;
  const Vec3 across = j - dot(p.right, j) * p.right;
  p.down = (1 / norm(across)) * across;
  return p;
}

double mean(const std::vector<Placed>& all, double Placed::*of) {
  double sum = 0;
  for (const Placed& p : all)
    sum += p.*of;
  return sum / static_cast<double>(all.size());
}

/// Slides every row along itself onto columns that are perpendicular to it. `observed`: 0 where a row does
/// not reach. Returns how many pixels now lie before a row's former first one.
std::int64_t unshear(Volume& images, double pixelsPerRow, std::vector<std::uint8_t>& observed) {
  const auto from = images.geometry.size;
  const double last = pixelsPerRow * static_cast<double>(from[1] - 1);
  const auto before = static_cast<std::int64_t>(std::ceil(std::max(0.0, -last)));
  auto& size = images.geometry.size;
  size[0] += static_cast<std::int64_t>(std::ceil(std::abs(last)));
  std::vector<float> voxels(static_cast<std::size_t>(images.geometry.voxelCount()), 0.F);
  observed.assign(voxels.size(), 0);
  for (std::int64_t row = 0; row < from[1] * from[2]; ++row) {
    const float* source = images.voxels.data() + row * from[0];
    const double shift = pixelsPerRow * static_cast<double>(row % from[1]) + static_cast<double>(before);
    for (std::int64_t i = 0; i < size[0]; ++i) {
      const double x = static_cast<double>(i) - shift;
      if (x < -1e-9 || x > static_cast<double>(from[0] - 1) + 1e-9) continue;
      const auto left = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x)), 0,
                                                 std::max<std::int64_t>(0, from[0] - 2));
      const auto right = std::min(left + 1, from[0] - 1);
      const auto share = static_cast<float>(x - static_cast<double>(left));
      const std::size_t at = static_cast<std::size_t>(row * size[0] + i);
      voxels[at] = source[left] + share * (source[right] - source[left]);
      observed[at] = 1;
    }
  }
  images.voxels = std::move(voxels);
  return before;
}

/// Averages squares of `factor` pixels; a square counts as observed if all of it is.
void shrink(Volume& images, std::vector<std::uint8_t>& observed, std::int64_t factor) {
  const auto from = images.geometry.size;
  auto& size = images.geometry.size;
  for (std::size_t a = 0; a < 2; ++a)
    size[a] /= factor;
  std::vector<float> voxels(static_cast<std::size_t>(images.geometry.voxelCount()));
  std::vector<std::uint8_t> whole(observed.empty() ? 0 : voxels.size(), 1);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i, ++at) {
        double sum = 0;
        for (std::int64_t y = 0; y < factor; ++y)
          for (std::int64_t x = 0; x < factor; ++x) {
            const auto v =
                static_cast<std::size_t>(i * factor + x + from[0] * (j * factor + y + from[1] * k));
            sum += images.voxels[v];
            if (!observed.empty() && !observed[v]) whole[at] = 0;
          }
        voxels[at] = static_cast<float>(sum / static_cast<double>(factor * factor));
      }
  images.voxels = std::move(voxels);
  observed = std::move(whole);
}

/// The usual distance between images in a row, mm: of their corners, along their normals; not more than lets
/// all of them lie within the sweep.
double distanceOf(const std::vector<Placed>& all, double width, double height, const Vec3& normal) {
  const auto corner = [&](const Placed& p, int n) {
    return p.corner + ((n & 1) ? width : 0.0) * p.right + ((n & 2) ? height : 0.0) * p.down;
  };
  std::vector<double> steps;
  double low = INFINITY, high = -INFINITY;
  for (std::size_t n = 0; n < all.size(); ++n) {
    double step = 0;
    for (int c = 0; c < 4; ++c) {
      const Vec3 x = corner(all[n], c);
      low = std::min(low, dot(x, normal));
      high = std::max(high, dot(x, normal));
      if (n > 0) step += 0.25 * std::abs(dot(x - corner(all[n - 1], c), cross(all[n].right, all[n].down)));
    }
    if (n > 0) steps.push_back(step);
  }
  std::nth_element(steps.begin(), steps.begin() + std::ssize(steps) / 2, steps.end());
  return std::min(steps[steps.size() / 2], (high - low) / static_cast<double>(steps.size()));
}

std::string imagesText(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " image" : " images");
}

constexpr double kRightAngle = 1e-3, kMostShear = 0.2; // cosines between rows and columns
constexpr double kSameShape = 5e-3;                    // between images, of pixel sizes and that cosine
constexpr double kBeam = 1;                            // mm
constexpr double kLeastDistance = 1e-3;                // mm
constexpr double kPixelsPerSlice = 4;                  // that a beam or the distance between images may hold

/// The images that were tracked, with one pixel size and shear.
std::vector<Placed> placedImages(const SweepFields& fields, std::size_t count,
                                 const NamedTransforms& calibration, const std::string& what) {
  const auto steps = wayToReference(fields, calibration);
  if (!steps) throw Error(ErrorCode::UnsupportedImage, whyNotPlaced(fields, calibration, what));
  SweepFrame all;
  const std::vector<SweepFrame> frames = framesOf(fields, count, all);
  std::vector<Placed> found;
  for (std::size_t n = 0; n < count; ++n)
    if (const auto place = placeOf(frames[n], all, *steps, calibration, what))
      found.push_back(placed(*place, n));
  if (found.size() < 2)
    throw Error(ErrorCode::UnsupportedImage, what + " has " +
                                                 (found.empty() ? "no image" : "a single image") +
                                                 " that was tracked; at least two are needed.");
  for (const Placed& p : found) {
    const Placed& first = found.front();
    if (std::abs(p.pixel / first.pixel - 1) > kSameShape || std::abs(p.line / first.line - 1) > kSameShape ||
        std::abs(p.shear - first.shear) > kSameShape)
      throw Error(ErrorCode::Geometry,
                  what + " has transforms that are not rigid (image " + std::to_string(p.frame) +
                      " is scaled or sheared unlike the first): export the sweep again.");
  }
  if (const double shear = mean(found, &Placed::shear); std::abs(shear) > kMostShear)
    throw Error(ErrorCode::Geometry,
                what + formatted(" has images whose rows and columns meet at %.0f degrees: check its "
                                 "calibration.",
                                 57.29577951308232 * std::acos(shear)));
  return found;
}

} // namespace

NamedTransforms readCalibration(const std::filesystem::path& path) {
  checkInputFile(path);
  std::ifstream in(path, std::ios::binary);
  std::string start(1 << 16, '\0');
  in.read(start.data(), std::ssize(start));
  start.resize(static_cast<std::size_t>(in.gcount()));
  const std::string no = quoted(path) + " holds no calibration: give a PLUS configuration (.xml) with the "
                                        "transform from Image to Probe, or a text file of its 16 numbers.";
  if (const auto map = affineFrom(start)) return {{"ImageToProbe", *map}};
  const std::size_t first = start.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string::npos || start[first] != '<') throw Error(ErrorCode::FileFormat, no);
  return withItk(ErrorCode::FileFormat, quoted(path) + " is a damaged XML file; copy or export it again.",
                 [&] {
                   const auto reader = ConfigurationReader::New();
                   reader->SetFilename(utf8(path));
                   reader->GenerateOutputInformation();
                   if (!reader->damaged.empty())
                     throw Error(ErrorCode::FileFormat, quoted(path) + " has a transform " + reader->damaged +
                                                            " that is no affine map of 16 numbers.");
                   if (reader->transforms.empty()) throw Error(ErrorCode::FileFormat, no);
                   return reader->transforms;
                 });
}

std::string whyNotPlaced(const SweepFields& fields, const NamedTransforms& calibration,
                         const std::string& what) {
  if (wayToReference(fields, calibration)) return {};
  bool fromImage = false;
  for (const auto& [key, value] : fields)
    fromImage = fromImage || (key.ends_with("Transform") && key.find("ImageTo") != std::string::npos);
  for (const auto& [name, map] : calibration)
    fromImage = fromImage || name.starts_with("ImageTo");
  return what + (fromImage
                     ? " is a tracked sweep without transforms that lead from Image to Reference, Patient, "
                       "World, RAS or Tracker; export it with them."
                     : " is a tracked sweep that does not say how its images lie to the probe (no "
                       "transform ImageToProbe); give its calibration.");
}

Stack placedSweep(Volume images, const SweepFields& fields, const NamedTransforms& calibration,
                  const std::string& what) {
  const auto count = static_cast<std::size_t>(images.geometry.size[2]);
  const std::vector<Placed> all = placedImages(fields, count, calibration, what);
  const auto orientation = fields.find("UltrasoundImageOrientation");
  orient(images, orientation == fields.end() ? "" : orientation->second, what);
  Stack stack;
  if (all.size() < count) { // keep those that were tracked
    const auto plane = static_cast<std::ptrdiff_t>(images.geometry.size[0] * images.geometry.size[1]);
    for (std::size_t n = 0; n < all.size(); ++n)
      if (all[n].frame != n)
        std::copy_n(images.voxels.begin() + static_cast<std::ptrdiff_t>(all[n].frame) * plane, plane,
                    images.voxels.begin() + static_cast<std::ptrdiff_t>(n) * plane);
    images.geometry.size[2] = std::ssize(all);
    images.voxels.resize(static_cast<std::size_t>(images.geometry.voxelCount()));
    stack.remarks.push_back(what + " has " + imagesText(count - all.size()) + " of " + std::to_string(count) +
                            " without valid pixels or transforms: they were left out.");
  }
  const double shear = mean(all, &Placed::shear);
  double pixel = mean(all, &Placed::pixel), line = mean(all, &Placed::line);
  std::int64_t before = 0;
  if (std::abs(shear) > kRightAngle) {
    before = unshear(images, shear * line / pixel, stack.observed);
    line *= std::sqrt(1 - shear * shear);
    stack.remarks.push_back(what + formatted(" has images whose rows and columns meet at %.1f degrees by its "
                                             "calibration: they were resampled.",
                                             57.29577951308232 * std::acos(shear)));
  }

  GridGeometry& g = images.geometry;
  const Placed& middle = all[all.size() / 2];
  Vec3 normal = cross(middle.right, middle.down);
  double side = 1; // the normal follows the sweep
  if (dot(all.back().corner - all.front().corner, normal) < 0) side = -1;
  normal = side * normal;
  double width = pixel * static_cast<double>(g.size[0] - 1),
         height = line * static_cast<double>(g.size[1] - 1);
  const double distance = distanceOf(all, width, height, normal);
  if (!(distance > kLeastDistance))
    throw Error(ErrorCode::Geometry,
                what + " has images that all lie in one place; give a sweep that moves.");
  Vec3 first{-static_cast<double>(before) * pixel, 0, 0}; // to the first pixel, along right and down
  const std::int64_t most = std::min(g.size[0], g.size[1]) / 2;
  const auto factor = std::min(
      most, static_cast<std::int64_t>(std::min(distance, kBeam) / (kPixelsPerSlice * std::max(pixel, line))));
  if (factor > 1) {
    shrink(images, stack.observed, factor);
    const double middleOf = 0.5 * static_cast<double>(factor - 1);
    first = first + Vec3{middleOf * pixel, middleOf * line, 0};
    stack.remarks.push_back(
        what +
        formatted(" has pixels much finer than its images lie apart: squares of %d of them were averaged "
                  "to %.2g x %.2g mm.",
                  static_cast<int>(factor * factor), static_cast<double>(factor) * pixel,
                  static_cast<double>(factor) * line));
    pixel *= static_cast<double>(factor);
    line *= static_cast<double>(factor);
    width = pixel * static_cast<double>(g.size[0] - 1);
    height = line * static_cast<double>(g.size[1] - 1);
  }
  g.spacing = {pixel, line, distance};
  const auto directions = [side](const Placed& p) {
    const Vec3 k = side * cross(p.right, p.down);
    Mat3 d;
    for (int row = 0; row < 3; ++row)
      d[row] = {p.right[row], p.down[row], k[row]};
    return d;
  };
  g.direction = directions(middle);
  // The grid lies around the middle of all images.
  Vec3 centre{0, 0, 0};
  std::vector<Vec3> corners;
  for (const Placed& p : all) {
    corners.push_back(p.corner + first[0] * p.right + first[1] * p.down);
    centre = centre + (1 / static_cast<double>(all.size())) *
                          (corners.back() + (0.5 * width) * p.right + (0.5 * height) * p.down);
  }
  g.origin = {0, 0, 0};
  g.origin = centre - g.centre();
  for (std::size_t n = 0; n < all.size(); ++n) {
    Affine3 pose{directions(all[n]) * transpose(g.direction), {}};
    pose.offset = corners[n] -
                  pose.linear * (g.origin + (static_cast<double>(n) * g.spacing[2]) * column(g.direction, 2));
    stack.poses.push_back(pose);
  }
  stack.thickness = kBeam;
  stack.image = std::move(images);
  checkGeometry(stack.image.geometry, what);
  return stack;
}

} // namespace innergs
