#include "Widgets/PreviewView.h"

#include <QPainter>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace innergs::ui {
namespace {

constexpr int kGap = 4;          // pixels between the planes
constexpr int kMostPixels = 256; // along one side of a plane

/// An anatomical axis in the image: the nearest index axis, and whether it points the same way.
struct AxisMap {
  int axis = 0;
  bool forward = true;
  double spacing = 1; // mm
};

/// Right, anterior, superior.
std::array<AxisMap, 3> anatomicalAxes(vtkMatrix4x4* m) {
  std::array<int, 3> best{0, 1, 2}, order{0, 1, 2};
  double most = -1;
  const auto length = [m](int a) {
    return std::hypot(m->GetElement(0, a), m->GetElement(1, a), m->GetElement(2, a));
  };
  do {
    double sum = 0;
    for (int r = 0; r < 3; ++r)
      sum += std::abs(m->GetElement(r, order[r])) / std::max(1e-9, length(order[r]));
    if (sum > most + 1e-9) most = sum, best = order;
  } while (std::next_permutation(order.begin(), order.end()));
  std::array<AxisMap, 3> map;
  for (int r = 0; r < 3; ++r)
    map[r] = {best[r], m->GetElement(r, best[r]) >= 0, std::max(1e-9, length(best[r]))};
  return map;
}

/// The pixels of a plane, row by row, from the offsets of its rows and columns in the voxels.
template <class T>
void gather(const T* voxels, const std::vector<std::ptrdiff_t>& columns,
            const std::vector<std::ptrdiff_t>& rows, std::vector<float>& values) {
  std::size_t n = 0;
  for (const std::ptrdiff_t row : rows)
    for (const std::ptrdiff_t column : columns)
      values[n++] = static_cast<float>(voxels[row + column]);
}

} // namespace

PreviewView::PreviewView(QWidget* parent) : HeightForWidth(parent) {
  setAccessibleName(tr("Preview of the result: axial, coronal and sagittal slice"));
  setToolTip(
      tr("The result so far: middle axial, coronal and sagittal slice;\npatient's right on the left."));
}

void PreviewView::setImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  if (!image || image->GetNumberOfPoints() == 0 || image->GetNumberOfScalarComponents() < 1) return clear();
  vtkNew<vtkMatrix4x4> identity;
  const auto axes = anatomicalAxes(ijkToRAS ? ijkToRAS : identity.GetPointer());
  int extent[6];
  image->GetExtent(extent);
  vtkIdType step[3];
  image->GetIncrements(step);
  // Across and up on the screen, as anatomical axes; the sign says whether they increase to the right and up.
  struct Sides {
    int across, up;
    bool acrossGrows, upGrows;
  };
  constexpr Sides views[3] = {{0, 1, false, true}, {0, 2, false, true}, {1, 2, false, true}};
  std::array<std::vector<float>, 3> values;
  float low = INFINITY, high = -INFINITY;
  for (int v = 0; v < 3; ++v) {
    const AxisMap across = axes[views[v].across], up = axes[views[v].up];
    const auto count = [&](int axis) { return extent[2 * axis + 1] - extent[2 * axis] + 1; };
    const int nx = count(across.axis), ny = count(up.axis);
    const int width = std::min(nx, kMostPixels), height = std::min(ny, kMostPixels);
    values[v].resize(static_cast<std::size_t>(width) * height);
    const int third = 3 - across.axis - up.axis;
    std::vector<std::ptrdiff_t> columns(width), rows(height);
    for (int x = 0; x < width; ++x) {
      const int i = static_cast<int>((x + 0.5) * nx / width);
      columns[x] = (across.forward == views[v].acrossGrows ? i : nx - 1 - i) * step[across.axis];
    }
    for (int y = 0; y < height; ++y) {
      const int j = static_cast<int>((y + 0.5) * ny / height);
      rows[y] =
          (up.forward == views[v].upGrows ? ny - 1 - j : j) * step[up.axis] + count(third) / 2 * step[third];
    }
    switch (image->GetScalarType()) {
      vtkTemplateMacro(
          gather(static_cast<const VTK_TT*>(image->GetScalarPointer()), columns, rows, values[v]));
    }
    for (const float value : values[v])
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    planes_[v].image = QImage(width, height, QImage::Format_Grayscale8);
    planes_[v].size = QSizeF(nx * across.spacing, ny * up.spacing);
  }
  const float range = high > low ? high - low : 1;
  for (int v = 0; v < 3; ++v)
    for (int y = 0; y < planes_[v].image.height(); ++y) {
      uchar* line = planes_[v].image.scanLine(y);
      const float* row = values[v].data() + static_cast<std::size_t>(y) * planes_[v].image.width();
      for (int x = 0; x < planes_[v].image.width(); ++x)
        line[x] = std::isfinite(row[x])
                      ? static_cast<uchar>(std::lround(255 * std::clamp((row[x] - low) / range, 0.f, 1.f)))
                      : 0;
    }
  updateGeometry();
  update();
}

void PreviewView::clear() {
  planes_ = {};
  updateGeometry();
  update();
}

double PreviewView::scale(int width) const {
  double mm = 0;
  for (const PlanePicture& plane : planes_)
    mm += plane.size.width();
  return mm > 0 ? std::max(1, width - 2 * kGap) / mm : 0;
}

int PreviewView::heightForWidth(int width) const {
  double tallest = 0;
  for (const PlanePicture& plane : planes_)
    tallest = std::max(tallest, plane.size.height());
  const int most = 14 * fontMetrics().lineSpacing();
  return std::min(most, static_cast<int>(std::ceil(tallest * scale(width))));
}

void PreviewView::paintEvent(QPaintEvent*) {
  if (isEmpty()) return;
  double tallest = 0, wide = 0;
  for (const PlanePicture& plane : planes_) {
    tallest = std::max(tallest, plane.size.height());
    wide += plane.size.width();
  }
  const double mm = std::min(scale(width()), height() / std::max(1e-9, tallest));
  QPainter painter(this);
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  double x = (width() - wide * mm - 2 * kGap) / 2;
  for (const PlanePicture& plane : planes_) {
    const QSizeF size = plane.size * mm;
    painter.drawImage(QRectF(QPointF(x, (height() - size.height()) / 2), size), plane.image);
    x += size.width() + kGap;
  }
}

} // namespace innergs::ui
