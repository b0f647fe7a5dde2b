#include "Widgets/PlanePicture.h"

#include "Widgets/PlaneWorker.h"

#include <QCoreApplication>
#include <QDir>
#include <QImage>
#include <QSaveFile>
#include <QStringList>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <algorithm>
#include <cmath>

namespace innergs::ui {
namespace {

struct PlanePicture {
  Q_DECLARE_TR_FUNCTIONS(innergs::ui::PlanePicture)
};

} // namespace

QString savePicture(const PlaneImage& plane, double lower, double upper, const QString& file) {
  int size[3];
  plane.shown()->GetDimensions(size);
  QImage picture(size[0], size[1], QImage::Format_Grayscale8);
  if (picture.isNull())
    return PlanePicture::tr("The picture does not fit in memory: choose a larger pixel size.");
  const auto* pixels = static_cast<const float*>(plane.shown()->GetScalarPointer());
  const double scale = 255 / std::max(upper - lower, 1e-30);
  for (int y = 0; y < size[1]; ++y) {
    uchar* line = picture.scanLine(size[1] - 1 - y);
    const float* row = pixels + static_cast<std::ptrdiff_t>(y) * size[0];
    for (int x = 0; x < size[0]; ++x)
      line[x] = static_cast<uchar>(std::lround(std::clamp((row[x] - lower) * scale, 0., 255.)));
  }
  const int perMetre = static_cast<int>(std::clamp(std::lround(1000 / plane.task.pixelSize), 1L, 100000000L));
  picture.setDotsPerMeterX(perMetre);
  picture.setDotsPerMeterY(perMetre);
  QStringList matrix;
  for (int i = 0; i < 16; ++i)
    matrix << QString::number(plane.ijkToRAS->GetElement(i / 4, i % 4), 'g', 9);
  picture.setText(QStringLiteral("PixelToRAS"),
                  matrix.join(QLatin1Char(' ')) + QStringLiteral(" (rows from the bottom up; mm)"));
  picture.setText(QStringLiteral("Window"), QStringLiteral("%1 %2").arg(lower).arg(upper));

  QSaveFile out(file);
  if (out.open(QIODevice::WriteOnly) && picture.save(&out, "PNG") && out.commit()) return {};
  return PlanePicture::tr("'%1' could not be written (%2): choose another folder or name.")
      .arg(QDir::toNativeSeparators(file), out.errorString());
}

} // namespace innergs::ui
