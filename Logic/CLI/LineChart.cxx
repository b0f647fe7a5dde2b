#include "CLI/LineChart.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace innergs::cli {
namespace {

constexpr int kWidth = 1240, kHeight = 640, kLeft = 84, kTop = 64, kBottom = 76, kLegend = 440;
constexpr double kTallest = 24; // dB: the first iterations are not informative
constexpr Colour kBackground{24, 24, 28}, kGrid{58, 58, 64}, kFaint{170, 170, 170}, kTextColour{255, 255, 255};

struct Range {
  double low = 1e300, high = -1e300;
  void take(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

/// A step of 1, 2 or 5 times a power of ten that divides the range into about six.
double niceStep(double range) {
  const double raw = range / 6, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * power) return factor * power;
  return 10 * power;
}

struct ChartAxes {
  Range x, y; // x: log10
  double left = kLeft, right = kWidth - kLegend, top = kTop, bottom = kHeight - kBottom;

  std::array<double, 2> at(double logX, double value) const {
    return {left + (right - left) * (logX - x.low) / (x.high - x.low),
            bottom - (bottom - top) * (value - y.low) / (y.high - y.low)};
  }
};

ChartAxes axesOf(const std::vector<Series>& series) {
  ChartAxes axes;
  for (const Series& one : series)
    for (const auto* points : {&one.points, &one.dots})
      for (const auto& [x, y] : *points)
        if (x > 0 && std::isfinite(y)) {
          axes.x.take(std::log10(x));
          axes.y.take(y);
        }
  if (axes.x.low > axes.x.high) axes.x = {0, 1}, axes.y = {0, 1}; // nothing to draw
  if (axes.x.high - axes.x.low < 0.1) axes.x = {axes.x.low - 0.05, axes.x.high + 0.05};
  if (axes.y.high - axes.y.low < 0.1) axes.y = {axes.y.low - 0.05, axes.y.high + 0.05};
  axes.y.low = std::max(axes.y.low, axes.y.high - kTallest);
  const double margin = 0.04 * (axes.y.high - axes.y.low);
  axes.y.low -= margin;
  axes.y.high += margin;
  return axes;
}

void drawGrid(Picture& picture, const ChartAxes& axes) {
  for (double decade = std::floor(axes.x.low); decade <= axes.x.high; ++decade)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double logX = decade + std::log10(factor);
      if (logX < axes.x.low || logX > axes.x.high) continue;
      const double x = axes.at(logX, axes.y.low)[0];
      drawLine(picture, {x, axes.top}, {x, axes.bottom}, 1, kGrid);
      const std::string label = fmt::format("{:g}", factor * std::pow(10.0, decade));
      picture.text(static_cast<int>(x) - Picture::textWidth(label) / 2, static_cast<int>(axes.bottom) + 6,
                   label, kFaint);
    }
  const double step = niceStep(axes.y.high - axes.y.low);
  for (double value = std::ceil(axes.y.low / step) * step; value <= axes.y.high; value += step) {
    const double y = axes.at(axes.x.low, value)[1];
    drawLine(picture, {axes.left, y}, {axes.right, y}, 1, kGrid);
    const std::string label = fmt::format("{:g}", std::round(value * 1e6) / 1e6);
    picture.text(static_cast<int>(axes.left) - 8 - Picture::textWidth(label), static_cast<int>(y) - 6, label,
                 kFaint);
  }
}

} // namespace

Colour seriesColour(std::size_t n) {
  // Okabe and Ito's colours, distinguishable with colour blindness; lightened for a dark background.
  constexpr Colour colours[] = {{86, 180, 233},  {230, 159, 0},   {0, 190, 140},
                                {240, 228, 66},  {230, 110, 40},  {214, 139, 187},
                                {150, 150, 255}, {200, 200, 200}, {255, 90, 110}};
  return colours[n % std::size(colours)];
}

void drawLine(Picture& picture, std::array<double, 2> a, std::array<double, 2> b, double width,
              Colour colour) {
  const double half = 0.5 * width, dx = b[0] - a[0], dy = b[1] - a[1], length2 = dx * dx + dy * dy;
  const auto limit = [](double v) { return static_cast<int>(std::clamp(v, -10.0, 20'000.0)); };
  for (int y = limit(std::min(a[1], b[1]) - half - 1); y <= limit(std::max(a[1], b[1]) + half + 1); ++y)
    for (int x = limit(std::min(a[0], b[0]) - half - 1); x <= limit(std::max(a[0], b[0]) + half + 1); ++x) {
      if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) continue;
      const double along =
          length2 > 0 ? std::clamp(((x - a[0]) * dx + (y - a[1]) * dy) / length2, 0.0, 1.0) : 0.0;
      const double distance = std::hypot(x - a[0] - along * dx, y - a[1] - along * dy);
      const double cover = std::clamp(half + 0.5 - distance, 0.0, 1.0);
      if (cover == 0) continue;
      std::uint8_t* pixel = picture.rgb.data() + 3 * (static_cast<std::size_t>(y) * picture.width + x);
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + cover * (colour[c] - pixel[c])));
    }
}

Picture lineChart(const std::vector<Series>& series, const ChartText& text) {
  Picture picture(kWidth, kHeight, kBackground);
  const ChartAxes axes = axesOf(series);
  drawGrid(picture, axes);
  for (std::size_t n = 0; n < series.size(); ++n) {
    const Colour colour = seriesColour(n);
    const std::array<double, 2>* before = nullptr;
    for (const auto& point : series[n].points) {
      if (!(point[0] > 0) || !(point[1] >= axes.y.low) || !std::isfinite(point[1])) continue;
      const auto from = before ? *before : point;
      drawLine(picture, axes.at(std::log10(from[0]), from[1]), axes.at(std::log10(point[0]), point[1]), 2,
               colour);
      before = &point;
    }
    for (const auto& dot : series[n].dots)
      if (dot[0] > 0 && dot[1] >= axes.y.low && std::isfinite(dot[1])) {
        const auto centre = axes.at(std::log10(dot[0]), dot[1]);
        drawLine(picture, centre, centre, 11, colour);
        drawLine(picture, centre, centre, 5, kBackground);
      }
    const int left = kWidth - kLegend + 28, top = kTop + 22 * static_cast<int>(n);
    drawLine(picture, {left + 0.0, top + 6.0}, {left + 24.0, top + 6.0}, 3, colour);
    picture.text(left + 34, top, series[n].label, kTextColour);
  }
  picture.text(kLeft, 18, text.title, kTextColour, 2);
  picture.text(8, kTop - 20, text.yLabel, kFaint);
  const int middle = static_cast<int>(0.5 * (axes.left + axes.right));
  picture.text(middle - Picture::textWidth(text.xLabel) / 2, kHeight - kBottom + 28, text.xLabel, kFaint);
  picture.text(kLeft, kHeight - 24, text.note, kFaint);
  return picture;
}

} // namespace innergs::cli
