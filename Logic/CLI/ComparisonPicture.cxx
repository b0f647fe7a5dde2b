#include "CLI/ComparisonPicture.h"

#include "CLI/ColorMaps.h"
#include "Core/Base/Error.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace innergs::cli {
namespace {

constexpr int margin = 12, lineHeight = 32, letterHeight = 26, textScale = 2;

using ColourAt = std::function<Colour(const Vec3&)>; // at an index on the truth's lattice

// One plane through the middle of a lattice, in radiological orientation: the patient's left on the right,
// head up.
struct View {
  Plane plane;
  int across, down, through; // lattice axes
  bool flipAcross, flipDown;
  std::int64_t slice;
  int width, height; // pixels
  double step;       // mm per pixel

  View(const GridGeometry& g, Plane p, double mmPerPixel) : plane(p), step(mmPerPixel) {
    across = sliceAxis(g, p == Plane::Sagittal ? Plane::Coronal : Plane::Sagittal);
    down = sliceAxis(g, p == Plane::Axial ? Plane::Coronal : Plane::Axial);
    through = sliceAxis(g, p);
    flipAcross = g.direction[p == Plane::Sagittal ? 1 : 0][across] < 0;
    flipDown = p == Plane::Axial ? g.direction[1][down] < 0 : g.direction[2][down] > 0;
    slice = g.size[through] / 2;
    width = static_cast<int>(std::lround(g.extent()[across] / step));
    height = static_cast<int>(std::lround(g.extent()[down] / step));
  }

  void draw(Picture& picture, int left, int top, const GridGeometry& g, const ColourAt& colour) const {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        Vec3 index;
        index[across] = indexAt(flipAcross ? width - 1 - x : x, g, across);
        index[down] = indexAt(flipDown ? height - 1 - y : y, g, down);
        index[through] = static_cast<double>(slice);
        picture.set(left + x, top + y, colour(index));
      }
  }

private:
  double indexAt(int pixel, const GridGeometry& g, int axis) const {
    return (pixel + 0.5) * step / g.spacing[axis] - 0.5;
  }
};

// Value of the nearest voxel; NaN outside.
float valueAt(const Volume& volume, const Vec3& index) {
  std::array<std::int64_t, 3> voxel;
  for (int a = 0; a < 3; ++a) {
    voxel[a] = std::llround(index[a]);
    if (voxel[a] < 0 || voxel[a] >= volume.geometry.size[a]) return NAN;
  }
  return volume.voxels[voxel[0] + volume.geometry.size[0] * (voxel[1] + volume.geometry.size[1] * voxel[2])];
}

const MethodScore& method(const EvaluationReport& report,
                          const std::function<bool(const MethodScore&)>& wanted) {
  const MethodScore* best = nullptr;
  for (const auto& score : report.methods)
    if (score.volume && wanted(score) && (!best || score.psnr > best->psnr)) best = &score;
  if (!best)
    throw Error(ErrorCode::Internal, "A picture needs the Gaussians and another method: evaluate both.");
  return *best;
}

struct Column {
  std::string heading, subheading;
  ColourAt colour;
};

void drawErrorScale(Picture& picture, int left, int top) {
  constexpr int width = 240, height = 20;
  const std::string low = "error 0", high = fmt::format("{:.0f} % of the range", 100 * kErrorCeiling);
  picture.text(left, top - 3, low, kFaintText, textScale);
  left += Picture::textWidth(low, textScale) + margin;
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < height; ++y)
      picture.set(left + x, top + y, heat(x / (width - 1.0)));
  picture.text(left + width + margin, top - 3, high, kFaintText, textScale);
}

/// The plane's name, one letter below the other.
int labelHeight(const View& view) {
  return static_cast<int>(std::string(planeName(view.plane)).size()) * letterHeight;
}

/// Small volumes leave room for the name.
int rowHeight(const View& view) {
  return std::max(view.height, labelHeight(view)) + margin;
}

} // namespace

Picture comparisonPicture(const EvaluationReport& report, const std::string& title) {
  const Volume& truth = *report.truth;
  const Stack& scan = report.input->front();
  const GridGeometry& g = truth.geometry;
  const auto& gaussians = method(report, [](const auto& m) { return m.name == "gaussians"; });
  const auto& other = method(report, [](const auto& m) { return m.name != "gaussians"; });

  const GreyScale shade(truth);
  const auto image = [&](const Volume& volume) {
    return [&volume, shade](const Vec3& index) { return shade(valueAt(volume, index)); };
  };
  const auto error = [&](const Volume& volume) {
    return [&volume, &truth, peak = report.peak](const Vec3& index) {
      return heat(std::abs(valueAt(volume, index) - valueAt(truth, index)) / (kErrorCeiling * peak));
    };
  };
  const Affine3 toScan = inverse(scan.image.geometry.indexToWorld()) * g.indexToWorld();
  const auto score = [](const MethodScore& m) {
    return fmt::format("{:.2f} dB, SSIM {:.3f}", m.psnr, m.ssim);
  };
  const std::string scans =
      report.input->size() == 1 ? "input" : fmt::format("input 1 of {}", report.input->size());
  const std::vector<Column> columns{
      {scans, fmt::format("slices of {:g} mm", scan.image.geometry.spacing[2]),
       [&](const Vec3& index) { return shade(valueAt(scan.image, toScan(index))); }},
      {"InnerGS", score(gaussians), image(*gaussians.volume)},
      {"truth", "", image(truth)},
      {"error of InnerGS", score(gaussians), error(*gaussians.volume)},
      {"error of " + other.name, score(other), error(*other.volume)}};

  const double finest = *std::min_element(g.spacing.begin(), g.spacing.end());
  const Vec3 extent = g.extent();
  const double step = std::max(finest / 2, *std::max_element(extent.begin(), extent.end()) / 440);
  std::vector<View> views;
  int columnWidth = Picture::textWidth("error of totalvariation", textScale),
      height = margin + 4 * lineHeight + margin;
  for (const Plane plane : {Plane::Axial, Plane::Coronal, Plane::Sagittal}) {
    views.emplace_back(g, plane, step);
    columnWidth = std::max(columnWidth, views.back().width);
    height += rowHeight(views.back());
  }
  const int labelWidth = lineHeight;
  Picture picture(labelWidth + margin + static_cast<int>(columns.size()) * (columnWidth + margin), height,
                  kPictureBackground);
  picture.text(labelWidth + margin, margin, title, {255, 255, 255}, textScale);
  int left = labelWidth + margin;
  for (const auto& column : columns) {
    picture.text(left, margin + lineHeight, column.heading, {255, 255, 255}, textScale);
    picture.text(left, margin + 2 * lineHeight, column.subheading, kFaintText, textScale);
    int top = margin + 3 * lineHeight;
    for (const auto& view : views) {
      view.draw(picture, left + (columnWidth - view.width) / 2, top, g, column.colour);
      top += rowHeight(view);
    }
    left += columnWidth + margin;
  }
  int top = margin + 3 * lineHeight;
  for (const auto& view : views) {
    const std::string name = planeName(view.plane);
    int letterTop = top + std::max(0, view.height - labelHeight(view)) / 2;
    for (const char letter : name) {
      picture.text(margin, letterTop, std::string(1, letter), kFaintText, textScale);
      letterTop += letterHeight;
    }
    top += rowHeight(view);
  }
  if (report.protocol == "paper" && report.model && report.model->field.blending == Blending::Alpha)
    picture.text(labelWidth + margin, height - margin - 20,
                 "Alpha blending: all rows show the rendering along the axial slices' normal; the scores are "
                 "of each plane's own.",
                 kFaintText);
  drawErrorScale(picture, labelWidth + margin + 3 * (columnWidth + margin), height - margin - 26);
  return picture;
}

} // namespace innergs::cli
