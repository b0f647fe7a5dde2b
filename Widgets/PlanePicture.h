#pragma once
#include <QString>

namespace innergs::ui {

struct PlaneImage;

/// Writes the plane as displayed (8-bit grey, upright; lower and upper: scanner units shown as black and
/// white) to a PNG file, with its pixel size and position in the file's text. Returns "" or a sentence.
/// Replaces an existing file only by a complete one.
QString savePicture(const PlaneImage& plane, double lower, double upper, const QString& file);

} // namespace innergs::ui
