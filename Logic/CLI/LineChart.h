#pragma once
#include "CLI/Picture.h"

namespace innergs::cli {

/// One line of a chart, with optional rings in the same colour.
struct Series {
  std::string label;
  std::vector<std::array<double, 2>> points; // x ascending
  std::vector<std::array<double, 2>> dots;
};

struct ChartText {
  std::string title, xLabel, yLabel, note;
};

/// Draws lines over a logarithmic x axis with ticks and a legend; omits points with x ≤ 0 or far below the
/// others.
Picture lineChart(const std::vector<Series>& series, const ChartText& text);

/// The colour of the n-th line.
Colour seriesColour(std::size_t n);

/// Draws an antialiased line from a to b (pixels), `width` pixels wide.
void drawLine(Picture& picture, std::array<double, 2> a, std::array<double, 2> b, double width,
              Colour colour);

} // namespace innergs::cli
