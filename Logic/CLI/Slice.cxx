#include "CLI/Command.h"
#include "CLI/Options.h"
#include "CLI/Picture.h"

#include "Core/Base/Error.h"
#include "Core/Render/Render.h"
#include "Core/Uncertainty/Uncertainty.h"
#include "IO/FilePath.h"
#include "IO/OutputFiles.h"
#include "IO/VolumeIO.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace innergs::cli {
namespace {

enum class Plane { Axial, Coronal, Sagittal };

struct SliceOptions {
  std::string model, output, uncertainty, measured;
  std::optional<Plane> plane;
  std::optional<double> position;
  std::vector<double> centre, origin, normal, u, v, size, spacing;
  Frame frame;
  std::optional<double> window, level, fill;
  OutputType type = OutputType::Float32;
  Settings settings; // threads, selection and device
  bool quiet = false;
};

Vec3 vec3(const std::vector<double>& values) {
  return {values[0], values[1], values[2]};
}

Vec3 unit(const Vec3& a, const std::string& what) {
  if (!(norm(a) > 1e-9))
    throw Error(ErrorCode::InvalidArgument, what + " has no direction: give a vector that is not 0.");
  return 1 / norm(a) * a;
}

struct Axes {
  Vec3 u, v, n; // right-handed, unit
};

// Rows run to the patient's left (sagittal: to the back), columns to the back (axial) or downwards.
Axes axesOf(Plane plane) {
  switch (plane) {
  case Plane::Axial:
    return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  case Plane::Coronal:
    return {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  case Plane::Sagittal:
    return {{0, 1, 0}, {0, 0, -1}, {-1, 0, 0}};
  }
  return {};
}

Axes chooseAxes(const SliceOptions& o) {
  if (o.plane) return axesOf(*o.plane);
  const auto given = [&](const std::vector<double>& direction, const std::string& what) {
    return unit(o.frame.turned(vec3(direction)), what);
  };
  Axes axes;
  if (!o.u.empty()) {
    axes.u = given(o.u, "--u");
    const Vec3 v = given(o.v, "--v");
    axes.v = unit(v - dot(v, axes.u) * axes.u, "--v, seen across --u,");
    if (std::abs(dot(v, axes.u)) > 1e-3)
      throw Error(ErrorCode::InvalidArgument,
                  "--u and --v are not at right angles: a slice needs perpendicular axes.");
    axes.n = cross(axes.u, axes.v);
  } else {
    axes.n = given(o.normal, "--normal");
    const Vec3 side = std::abs(axes.n[0]) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    axes.u = unit(side - dot(side, axes.n) * axes.n, "--normal");
    axes.v = cross(axes.n, axes.u);
  }
  return axes;
}

GridGeometry slicePlane(const SliceOptions& o, const GridGeometry& domain) {
  const Axes axes = chooseAxes(o);
  Vec3 centre = o.centre.empty() ? domain.centre() : o.frame.turned(vec3(o.centre));
  if (o.position) {
    const int axis = *o.plane == Plane::Axial ? 2 : *o.plane == Plane::Coronal ? 1 : 0;
    centre[axis] = o.frame.turned({*o.position, *o.position, *o.position})[axis];
  }
  const Vec3 point = o.origin.empty() ? centre : o.frame.turned(vec3(o.origin));
  const Span along = reach(domain, axes.n);
  const double depth = dot(point, axes.n);
  if (depth < along.low || depth > along.high) {
    Vec3 middle = o.frame.turned(domain.centre());
    for (double& mm : middle)
      mm = std::round(10 * mm) / 10 + 0.0; // avoids "-0"
    throw Error(ErrorCode::Geometry,
                fmt::format("The plane passes {:.1f} mm beside the model, whose centre is at "
                            "{:g},{:g},{:g} ({}): choose another position.",
                            std::max(along.low - depth, depth - along.high), middle[0], middle[1], middle[2],
                            o.frame.name()));
  }

  GridGeometry plane;
  const double finest = *std::min_element(domain.spacing.begin(), domain.spacing.end());
  for (int a = 0; a < 2; ++a)
    plane.spacing[a] = o.spacing.empty() ? finest : o.spacing[o.spacing.size() == 1 ? 0 : a];
  plane.spacing[2] = finest;
  for (const double mm : plane.spacing)
    if (!(mm > 0)) throw Error(ErrorCode::InvalidArgument, "The pixel spacing must be above 0 mm.");
  const std::array<Span, 2> box{reach(domain, axes.u), reach(domain, axes.v)};
  std::array<double, 2> pixels;
  for (int a = 0; a < 2; ++a) {
    pixels[a] = o.size.empty() ? std::ceil((box[a].high - box[a].low) / plane.spacing[a] - 1e-6)
                               : o.size[o.size.size() == 1 ? 0 : a];
    if (!(pixels[a] >= 1 && pixels[a] <= 65536) || pixels[a] != std::floor(pixels[a]))
      throw Error(ErrorCode::InvalidArgument,
                  "The slice must have 1 to 65536 whole pixels a side: check --size and --spacing.");
    plane.size[a] = static_cast<std::int64_t>(pixels[a]);
  }
  plane.size[2] = 1;
  for (int row = 0; row < 3; ++row)
    plane.direction[row] = {axes.u[row], axes.v[row], axes.n[row]};
  if (!o.origin.empty()) {
    plane.origin = point;
    return plane;
  }
  const std::array<Vec3, 2> sides{axes.u, axes.v};
  plane.origin = depth * axes.n;
  for (int a = 0; a < 2; ++a) {
    const double middle = o.centre.empty() ? (box[a].low + box[a].high) / 2 : dot(centre, sides[a]);
    plane.origin = plane.origin + (middle - (pixels[a] - 1) / 2 * plane.spacing[a]) * sides[a];
  }
  return plane;
}

void writeGreyPng(const Volume& slice, const SliceOptions& o) {
  std::vector<float> sorted = slice.voxels;
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double q) { return sorted[static_cast<std::size_t>(q * (sorted.size() - 1))]; };
  double low = o.measured.empty() ? quantile(0.005) : 0, high = o.measured.empty() ? quantile(0.995) : 1;
  if (o.window || o.level) {
    const double window = o.window.value_or(high - low), level = o.level.value_or((low + high) / 2);
    low = level - window / 2;
    high = level + window / 2;
  }
  const double scale = high > low ? 255 / (high - low) : 0;
  std::vector<std::uint8_t> grey(slice.voxels.size());
  for (std::size_t n = 0; n < grey.size(); ++n)
    grey[n] = static_cast<std::uint8_t>(std::lround(std::clamp((slice.voxels[n] - low) * scale, 0.0, 255.0)));
  writePng(o.output, static_cast<int>(slice.geometry.size[0]), static_cast<int>(slice.geometry.size[1]), 1,
           grey);
}

Volume rendered(const GaussianField& field, const GridGeometry& plane, const SliceOptions& o) {
  RenderOptions render;
  render.threads = o.settings.threads;
  render.selection = o.settings.selection;
  render.device = renderDevice(o.settings.device, field, plane.voxelCount(), o.settings.selection);
  return innergs::render(field, plane, render);
}

Volume deviationOf(const GridGeometry& plane, const SliceOptions& o) {
  ThreadPool pool(o.settings.threads);
  return deviationOn(plane, readVolume(o.uncertainty), pool);
}

/// 1 where the nearest voxel is not 0; nothing is measured outside the volume.
Volume measuredOn(const GridGeometry& plane, const SliceOptions& o) {
  const Volume map = readVolume(o.measured);
  Mask mask{map.geometry, std::vector<std::uint8_t>(map.voxels.size())};
  std::transform(map.voxels.begin(), map.voxels.end(), mask.voxels.begin(),
                 [](float v) { return static_cast<std::uint8_t>(v != 0 && !std::isnan(v)); });
  const std::vector<std::uint8_t> measured = resampleMask(mask, plane);
  return {plane, {measured.begin(), measured.end()}};
}

int slice(const SliceOptions& o) {
  const bool png = fullExtension(o.output) == ".png";
  if (!o.plane && o.normal.empty() && o.u.empty())
    throw CLI::ValidationError("slice", "needs --plane, --normal or --u and --v");
  if (!png && (o.window || o.level))
    throw CLI::ValidationError("slice",
                               "--window and --level are for a .png; other images keep their values");
  if (png && o.type != OutputType::Float32)
    throw CLI::ValidationError("slice", "--type is for .nii, .nii.gz, .nrrd and .mha; a .png has 8 bits");
  OutputFiles files;
  files.read(o.model);
  files.read(o.uncertainty);
  files.read(o.measured);
  files.add(o.output, png ? OutputFiles::Kind::Png : OutputFiles::Kind::Volume);
  const GaussianField field = loadField(o.model, o.fill);
  const GridGeometry plane = slicePlane(o, field.region());
  checkMemory(8 * plane.voxelCount(), "The slice");
  const Volume image = !o.measured.empty()      ? measuredOn(plane, o)
                       : !o.uncertainty.empty() ? deviationOf(plane, o)
                                                : rendered(field, plane, o);
  if (png)
    writeGreyPng(image, o);
  else if (!o.measured.empty())
    warn(writeVolume(image, o.output, OutputType::UInt8));
  else if (!o.uncertainty.empty())
    warn(writeVolume(image, o.output, o.type));
  else
    writeRendered(image, field, o.output, o.type);
  if (!o.quiet)
    fmt::print(stderr, "Wrote {} ({}x{} pixels of {:g}x{:g} mm).\n", o.output, plane.size[0], plane.size[1],
               plane.spacing[0], plane.spacing[1]);
  return Success;
}

} // namespace

Subcommand addSlice(CLI::App& app) {
  auto* command = app.add_subcommand("slice", "Renders any plane of a model as an image");
  auto o = std::make_shared<SliceOptions>();
  addOption(*command, "model", o->model, "MODEL", "Model (.innergs) or Gaussians (.ply)")->required();
  addOption(
      *command, "-o,--output", o->output, "FILE",
      "Image to write: .nii, .nii.gz, .nrrd, .mha (one slice, positioned in the patient) or .png (8 bit)")
      ->required();
  auto* plane = addChoice<std::optional<Plane>>(
      *command, "--plane", o->plane,
      {{"axial", Plane::Axial}, {"coronal", Plane::Coronal}, {"sagittal", Plane::Sagittal}},
      "A standard plane");
  auto* position = addOption(*command, "--position", o->position, "MM",
                             "Where the standard plane cuts, in mm: z (axial), y (coronal) or x (sagittal)\n"
                             "[the model's centre]")
                       ->needs(plane);
  auto* normal =
      addNumbers(*command, "--normal", o->normal, {3}, "X,Y,Z",
                 "Normal of an oblique plane; rows then run to the patient's left as far as it allows")
          ->excludes(plane);
  auto* u =
      addNumbers(*command, "--u", o->u, {3}, "X,Y,Z", "Direction of the rows; with --v instead of --normal")
          ->excludes(plane)
          ->excludes(normal);
  auto* v = addNumbers(*command, "--v", o->v, {3}, "X,Y,Z", "Direction of the columns")->needs(u);
  u->needs(v);
  auto* centre = addNumbers(*command, "--center", o->centre, {3}, "X,Y,Z",
                            "Middle of the image, mm [the model's centre]")
                     ->excludes(position);
  addNumbers(*command, "--origin", o->origin, {3}, "X,Y,Z",
             "Centre of the first pixel, mm, instead of --center")
      ->excludes(centre)
      ->excludes(position);
  o->frame.add(*command);
  auto* uncertainty =
      addOption(*command, "--uncertainty", o->uncertainty, "FILE",
                "Shows this volume of reconstruct --uncertainty on the plane instead of the model");
  auto* measured =
      addOption(*command, "--measured", o->measured, "FILE",
                "Shows this volume of reconstruct --measured on the plane instead of the model: 1 where\n"
                "slices measured something, else 0 (8 bits; .png: white and black)")
          ->excludes(uncertainty);
  addNumbers(*command, "--size", o->size, {1, 2}, "N",
             "Pixels: one number or columns,rows [covers the model]");
  addNumbers(*command, "--spacing", o->spacing, {1, 2}, "MM",
             "Pixel size in mm: one number or x,y [the model's finest]");
  addOption(*command, "--window", o->window, "W",
            "PNG: width of the grey window, scanner units [99 % of the values]")
      ->check(CLI::PositiveNumber)
      ->excludes(measured);
  addOption(*command, "--level", o->level, "L", "PNG: middle of the grey window, scanner units")
      ->excludes(measured);
  addOutputType(*command, o->type)->excludes(measured);
  addFill(*command, o->fill);
  addSetting(*command, o->settings, "threads");
  addSetting(*command, o->settings, "selection");
  addSetting(*command, o->settings, "device", "Where to render; auto takes a GPU for many pixels [auto]");
  command->add_flag("-q,--quiet", o->quiet, "Print only errors");
  command->footer(
      "Examples:\n"
      "  innergs slice head.innergs --plane axial --position 12.5 -o axial.png\n"
      "  innergs slice head.innergs --ras --plane sagittal --position 30 -o right.png\n"
      "  innergs slice head.innergs --normal 0,1,1 --spacing 0.5 -o oblique.nii.gz\n"
      "  innergs slice head.innergs --u 1,0,0 --v 0,0.8,0.6 --center 0,10,20 --size 512 -o plane.nrrd");
  return {command, [o] { return slice(*o); }};
}

} // namespace innergs::cli
