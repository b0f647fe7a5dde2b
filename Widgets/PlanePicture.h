#pragma once
#include <QString>

namespace innergs::ui {

struct PlaneImage;

/// Writes the plane as it is seen (8-bit grey, right side up; lower and upper: scanner units that are black
/// and white) to a PNG file, with its pixel size and place in the file's text. "" or a sentence. An existing
/// file is replaced only by a complete one.
QString savePicture(const PlaneImage& plane, double lower, double upper, const QString& file);

} // namespace innergs::ui
