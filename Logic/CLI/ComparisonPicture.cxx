#include "CLI/ComparisonPicture.h"

#include "CLI/ColorMaps.h"
#include "CLI/PlaneView.h"
#include "Core/Base/Error.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace innergs::cli {
namespace {

constexpr int margin = 12, lineHeight = 32, letterHeight = 26, textScale = 2;

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
int labelHeight(const PlaneView& view) {
  return static_cast<int>(std::string(planeName(view.plane)).size()) * letterHeight;
}

/// Small volumes leave room for the name.
int rowHeight(const PlaneView& view) {
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
  std::vector<PlaneView> views;
  int columnWidth = Picture::textWidth("error of totalvariation", textScale),
      height = margin + 4 * lineHeight + margin;
  for (const Plane plane : {Plane::Axial, Plane::Coronal, Plane::Sagittal}) {
    views.emplace_back(g, plane, g.size[sliceAxis(g, plane)] / 2, step);
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
      view.draw(picture, left + (columnWidth - view.width) / 2, top, column.colour);
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
