#include "CLI/ExperimentPictures.h"

#include "CLI/ColorMaps.h"
#include "CLI/LineChart.h"
#include "CLI/PlaneView.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace innergs::cli {
namespace {

constexpr int kMargin = 12;
constexpr Colour kInk{255, 255, 255};
constexpr Colour kSliced{86, 180, 233}, kSplat{230, 60, 40};

void drawContour(Picture& picture, const std::vector<std::array<double, 2>>& contour, int left, int top,
                 int size, double extent, double width, Colour colour) {
  const auto pixel = [&](const std::array<double, 2>& p) {
    return std::array<double, 2>{left + (p[0] / extent + 1) * 0.5 * size - 0.5,
                                 top + (p[1] / extent + 1) * 0.5 * size - 0.5};
  };
  for (std::size_t n = 0; n < contour.size(); ++n)
    drawLine(picture, pixel(contour[n]), pixel(contour[(n + 1) % contour.size()]), width, colour);
}

/// The nearest voxel to an index on a grid.
std::size_t voxelAt(const GridGeometry& g, const Vec3& index) {
  std::array<std::int64_t, 3> voxel;
  for (int a = 0; a < 3; ++a)
    voxel[a] = std::clamp<std::int64_t>(std::llround(index[a]), 0, g.size[a] - 1);
  return static_cast<std::size_t>(voxel[0] + g.size[0] * (voxel[1] + g.size[1] * voxel[2]));
}

Series seriesOf(const std::string& label, const std::vector<FitPoint>& curve) {
  Series series;
  series.label = label;
  for (const FitPoint& point : curve)
    series.points.push_back({point.seconds, point.psnr});
  return series;
}

} // namespace

Picture contourPicture(const ContourResult& result) {
  constexpr int zoom = 1, textTop = 44;
  const int panel = result.example.front().size * zoom;
  Picture picture(kMargin + static_cast<int>(result.example.size()) * (panel + kMargin),
                  textTop + panel + 30 + 2 * 20 + kMargin, kPictureBackground);
  picture.text(kMargin, 10, "The conditional splat and the sliced 3D Gaussian", kInk, 2);
  int left = kMargin;
  for (const ContourSlice& slice : result.example) {
    for (int y = 0; y < panel; ++y)
      for (int x = 0; x < panel; ++x)
        picture.set(left + x, textTop + y,
                    grey(slice.sliced[static_cast<std::size_t>(y / zoom) * slice.size + x / zoom]));
    for (const auto& contour : slice.contours) {
      drawContour(picture, contour.sliced, left, textTop, panel, slice.extent, 5, kSliced);
      drawContour(picture, contour.splat, left, textTop, panel, slice.extent, 1.5, kSplat);
    }
    picture.text(left, textTop + panel + 6, fmt::format("t - mean = {:+g} sigma", slice.t), kFaintText);
    left += panel + kMargin;
  }
  const int top = textTop + panel + 30;
  drawLine(picture, {kMargin + 0.0, top + 6.0}, {kMargin + 30.0, top + 6.0}, 5, kSliced);
  picture.text(kMargin + 40, top, "3D Gaussian cut by the slice, p = 0.5, 0.1, 0.01 (by bisection)", kInk);
  drawLine(picture, {kMargin + 0.0, top + 26.0}, {kMargin + 30.0, top + 26.0}, 1.5, kSplat);
  picture.text(
      kMargin + 40, top + 20,
      fmt::format(
          "conditional splat p(u,v|t) p(t) (closed form); largest difference of p over {} points: {:.1e}",
          result.points, result.maximumError),
      kInk);
  return picture;
}

Picture staticPicture(const StaticExperiment& experiment, const std::string& title) {
  const Volume& truth = experiment.truth;
  const GridGeometry& g = truth.geometry;
  const int across = sliceAxis(g, Plane::Sagittal), down = sliceAxis(g, Plane::Coronal);
  const double finest = std::min(g.spacing[across], g.spacing[down]);
  const double longest = std::max(g.extent()[across], g.extent()[down]);
  const PlaneView slice(g, Plane::Axial, experiment.slice, std::max(finest / 2, longest / 360));
  const GreyScale shade(truth);

  const int columns = 1 + static_cast<int>(experiment.rows.size());
  const int columnWidth = std::max(slice.width, Picture::textWidth("alpha, the paper's training") + 4);
  constexpr int header = 84;
  Picture picture(kMargin + columns * (columnWidth + kMargin), header + 2 * (slice.height + kMargin) + 24,
                  kPictureBackground);
  picture.text(kMargin, 12, title, kInk, 2);
  int left = kMargin;
  picture.text(left, 48, "truth", kInk);
  picture.text(left, 64, fmt::format("axial slice {}, held out", experiment.slice), kFaintText);
  slice.draw(picture, left, header,
             [&](const Vec3& index) { return shade(truth.voxels[voxelAt(g, index)]); });
  picture.text(left, header + slice.height + kMargin, "error: black 0,", kFaintText);
  picture.text(left, header + slice.height + kMargin + 18,
               fmt::format("white {:.0f} % of the range", 100 * kErrorCeiling), kFaintText);
  for (const auto& row : experiment.rows) {
    left += columnWidth + kMargin;
    const Volume& image = *row.paper->gaussians.volume;
    picture.text(left, 48, row.label, kInk);
    picture.text(
        left, 64,
        fmt::format("{:.2f} dB, SSIM {:.4f} (P)", row.paper->gaussians.psnr, row.paper->gaussians.ssim),
        kFaintText);
    slice.draw(picture, left, header,
               [&](const Vec3& index) { return shade(image.voxels[voxelAt(g, index)]); });
    slice.draw(picture, left, header + slice.height + kMargin, [&](const Vec3& index) {
      const std::size_t p = voxelAt(g, index);
      return heat(std::abs(image.voxels[p] - truth.voxels[p]) / (kErrorCeiling * experiment.peak));
    });
  }
  return picture;
}

Picture ablationChart(const Ablation& ablation, const std::string& title) {
  std::vector<Series> series;
  for (const auto& [label, fit] : ablation.rows) {
    series.push_back(seriesOf(label, fit->curve));
    if (!fit->curve.empty()) series.back().dots.push_back({fit->curve.back().seconds, fit->gaussians.psnr});
  }
  return lineChart(series, {title, "seconds", "PSNR dB",
                            "Lines: on the fitted samples (not held out). Rings: on the held-out slices of "
                            "protocol P, at the end."});
}

Picture predictionChart(const PredictionAblation& ablation) {
  constexpr int line = 22, heading = 48, labels = 330, bars = 480, figures = 240, top = 48;
  int lines = 0;
  for (const auto& one : ablation.cases)
    lines += static_cast<int>(one.rows.size());
  Picture picture(2 * kMargin + labels + bars + figures,
                  top + heading * static_cast<int>(ablation.cases.size()) + line * lines + kMargin,
                  kPictureBackground);
  picture.text(kMargin, 16, ablation.table.title, kInk);
  int y = top;
  for (const auto& one : ablation.cases) {
    double low = INFINITY, high = -INFINITY;
    for (const auto& row : one.rows)
      if (row.quality && std::isfinite(row.quality->psnr)) {
        low = std::min(low, row.quality->psnr);
        high = std::max(high, row.quality->psnr);
      }
    const double floor = low - 0.1 * (high - low) - 0.1; // so that the shortest bar shows
    picture.text(kMargin, y + 18, fmt::format("{}; bars begin at {:.2f} dB", one.title, floor), kFaintText);
    y += heading;
    std::size_t colour = 0;
    for (std::size_t n = 0; n < one.rows.size(); ++n, y += line) {
      const auto& row = one.rows[n];
      if (n > 0 && row.family != one.rows[n - 1].family) ++colour;
      picture.text(kMargin, y, row.label, kInk);
      if (!row.quality) continue;
      const double left = kMargin + labels, middle = y + 6,
                   share = std::clamp((row.quality->psnr - floor) / (high - floor), 0.0, 1.0);
      drawLine(picture, {left, middle}, {left + share * bars, middle}, 12, seriesColour(colour));
      picture.text(kMargin + labels + bars + 16, y,
                   fmt::format("{:.2f} dB, {:.1f} s of CPU", row.quality->psnr, row.cpuSeconds), kFaintText);
    }
  }
  return picture;
}

} // namespace innergs::cli
